// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/xarm/tcp_stream.h"
#include "hil/xarm/xarm_protocol.h"
#include "hil/xarm/xarm_report.h"
#include "platform/core/time.h"

namespace pipewright::hil {

struct XarmControllerConfig {
  std::string address = "127.0.0.1";
  int request_port = 0;  ///< 0: any that is free
  int real_port = 0;
  int real_time_port = 0;
  std::string version = "7,7,XI1303,AC1303,v2.5.0";
  double accel_radps2 = 20;
  double limit_rad = 6.28;  ///< of every joint, either way
  XarmVector start_rad = XarmVector::Zero();
  Duration answer_delay{};
  /// What a connection carries in one Step(), so that messages come in pieces; 0: all.
  std::size_t bytes_per_step = 0;
  /// Steps between two that carry anything, so that messages come together; 1: each.
  int steps_per_send = 1;
};

/// A UFACTORY controller with a 7-joint arm: requests on one TCP port, reports on two, and joints
/// that follow joint velocities (mode 4) at an acceleration limit. Time is given; several clients.
///
///   mode, motion enable, clean error -> state 5, nothing moves; set state 0 -> ready
///   an error                         -> state 4, until it is cleaned
///   register 81 with a duration      -> the joints come to rest by themselves after it
///
/// Of its own to tests: what a person at the arm does, and what goes wrong.
class XarmController {
 public:
  explicit XarmController(const XarmControllerConfig& config = {});

  /// @returns an error in words, or nothing
  std::string Open();
  int request_port() const { return request_listener_.port(); }
  int report_port(XarmReportKind kind) const { return listener(kind).port(); }

  /// Hears, answers, moves for the time since the last call, and reports.
  void Step(Time now);

  void InjectError(int code);          ///< stops the arm
  void SetStickyError(int code);       ///< one that cleaning does not take away; 0: gone
  void TakeOver(int mode, int state);  ///< a person, or another client
  void Drop();                         ///< every connection
  void SetSilent(bool silent) { silent_ = silent; }  ///< no reports
  void SetDeaf(bool deaf) { deaf_ = deaf; }          ///< no request is read
  void SetReported(const std::optional<XarmVector>& position_rad) { reported_ = position_rad; }

  int mode() const { return mode_; }
  int state() const { return state_; }
  bool enabled() const { return enabled_; }
  int error() const { return sticky_error_ != 0 ? sticky_error_ : error_; }
  const XarmVector& position_rad() const { return position_rad_; }
  const XarmVector& velocity_radps() const { return velocity_radps_; }
  int clients() const;
  /// Every request so far, oldest first.
  const std::vector<XarmFrame>& heard() const { return heard_; }
  /// Bytes sent to, and come from, all clients of this port that are still connected.
  std::uint64_t sent(int port) const;
  std::uint64_t arrived(int port) const;

 private:
  struct Message {
    Time due{};
    std::vector<std::uint8_t> bytes;
  };
  struct Client {
    TcpStream stream;
    std::optional<XarmReportKind> report;  ///< none: of requests
    Time next_report{};
    std::deque<Message> out;
  };

  const TcpListener& listener(XarmReportKind kind) const {
    return kind == XarmReportKind::kReal ? real_listener_ : real_time_listener_;
  }
  void Accept(Time now);
  void Hear(Client& client, Time now);
  XarmFrame Answer(const XarmFrame& request, Time now);
  XarmFrame Set(const XarmFrame& request, int value);
  XarmFrame Velocity(const XarmFrame& request, Time now);
  std::uint8_t StateByte() const;
  bool CanMove() const;
  void Move(Time now);
  void Report(Client& client, Time now);
  void Flush(Client& client, Time now);

  XarmControllerConfig config_;
  TcpListener request_listener_;
  TcpListener real_listener_;
  TcpListener real_time_listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<XarmFrame> heard_;
  int mode_ = xarm_mode::kPosition;
  int state_ = xarm_state::kReset;
  bool enabled_ = false;
  int error_ = 0;
  int sticky_error_ = 0;
  bool silent_ = false;
  bool deaf_ = false;
  std::optional<XarmVector> reported_;
  XarmVector position_rad_;
  XarmVector velocity_radps_ = XarmVector::Zero();
  XarmVector target_radps_ = XarmVector::Zero();
  std::optional<Time> target_until_;
  std::optional<Time> stepped_;
  std::uint64_t steps_ = 0;
};

}  // namespace pipewright::hil

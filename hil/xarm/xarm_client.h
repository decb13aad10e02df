// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "hil/xarm/tcp_stream.h"
#include "hil/xarm/xarm_protocol.h"
#include "hil/xarm/xarm_report.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/time.h"

namespace pipewright::hil {

struct XarmClientConfig {
  std::string address = "192.168.1.2";  ///< IPv4, in figures
  int request_port = 502;
  XarmReportKind report = XarmReportKind::kReal;
  int report_port = ReportPort(XarmReportKind::kReal);
  Duration connect_timeout = std::chrono::seconds(1);
  Duration answer_timeout = std::chrono::milliseconds(100);
};

/// Why a controller cannot be spoken with any more.
enum class XarmProblem : std::uint8_t {
  kNone,
  kUnreachable,     ///< a connection was refused
  kConnectTimeout,  ///< nobody took it
  kClosed,          ///< a connection ended, or its other end did not read
  kMalformed,       ///< what came is no frame, or no report
  kNoAnswer,        ///< a request was not answered in time
  kSilent,          ///< no report came in time
};
const char* Name(XarmProblem problem);

/// A controller's requests and reports, over two TCP connections. Never waits, time is given, and
/// after a problem it is silent until told to connect again: whether to is not its to judge.
///
///   client.Connect(now);
///   each step:  client.Step(now);
///               while (client.TakeReport(report)) ...
///               while (client.TakeAnswer(answer)) ...
///               client.Ask(XarmAsk(XarmRegister::kGetError), now);
///
/// Requests may overlap. An answer is told by its transaction and register; one that nobody waits
/// for, and a frame of another protocol (the vendor's heartbeat is one), is counted and dropped.
class XarmClient {
 public:
  static constexpr int kUnderWay = 8;    ///< requests unanswered, or answers not taken
  static constexpr int kReportsMax = 8;  ///< not taken; older ones are dropped

  explicit XarmClient(const XarmClientConfig& config) : config_(config) {}

  /// Drops what there is and begins afresh.
  void Connect(Time now);
  void Close();
  void Step(Time now);

  /// kUnavailable: not up(); kFull: kUnderWay; kFault: it could not be sent, and that is a problem.
  Status Ask(XarmFrame request, Time now);
  bool TakeAnswer(XarmFrame& answer);
  bool TakeReport(XarmReport& report);

  bool up() const { return requests_.open() && reports_.open(); }
  bool connecting() const { return requests_.connecting() || reports_.connecting(); }
  XarmProblem problem() const { return problem_; }
  int unanswered() const { return waiting_.size(); }
  std::uint64_t asked() const { return asked_; }
  std::uint64_t strays() const { return strays_; }            ///< frames that nobody waits for
  std::uint64_t bad_reports() const { return bad_reports_; }  ///< of what no arm can do

  const TcpStream& requests() const { return requests_; }
  const TcpStream& reports() const { return reports_; }

 private:
  struct Waiting {
    std::uint16_t transaction = 0;
    std::uint8_t register_number = 0;
    Time since{};
  };

  void Fail(XarmProblem problem);
  void CheckConnections(Time now);
  void ReadAnswers();
  void ReadReports();
  void OnAnswer(const XarmFrame& answer);

  XarmClientConfig config_;
  TcpStream requests_;
  TcpStream reports_;
  bool wanted_ = false;
  bool was_up_ = false;
  Time connect_since_{};
  XarmProblem problem_ = XarmProblem::kNone;
  std::uint16_t transaction_ = 0;
  FixedVector<Waiting, kUnderWay> waiting_;
  FixedVector<XarmFrame, kUnderWay> answers_;
  FixedVector<XarmReport, kReportsMax> fresh_;
  std::uint64_t asked_ = 0;
  std::uint64_t strays_ = 0;
  std::uint64_t bad_reports_ = 0;
};

}  // namespace pipewright::hil

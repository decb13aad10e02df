// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/devices/cia402_node.h"
#include "hil/devices/port.h"
#include "hil/xarm/xarm_client.h"

namespace pipewright::hil {

struct XarmGatewayConfig {
  XarmClientConfig controller;
  /// Soft limits of the nodes (607Dh). A joint is measured some 30 ms late and braked at
  /// brake_radps2, which takes it past them by about brake t^2 / 2 = 2 mrad.
  XarmVector lower_rad = XarmVector::Constant(-6.26);
  XarmVector upper_rad = XarmVector::Constant(6.26);
  double brake_radps2 = 5;
  /// After which the controller ends a velocity by itself: what stops the arm when we are no more.
  Duration velocity_duration = std::chrono::milliseconds(40);
  Duration resend = std::chrono::milliseconds(15);    ///< of the velocities when no SYNC comes
  Duration least_gap = std::chrono::milliseconds(4);  ///< between two; a controller takes 250 Hz
  Duration report_timeout = std::chrono::milliseconds(50);
  Duration enable_timeout = std::chrono::seconds(2);
  Duration rest_timeout = std::chrono::milliseconds(500);
  Duration retry = std::chrono::seconds(1);        ///< to connect; never after a loss at work
  Duration poll = std::chrono::milliseconds(500);  ///< between questions while idle
  double rest_radps = 5e-3;

  bool Valid() const;
};

/// The EMCY codes of its own, and what their manufacturer bytes say, first byte lowest.
namespace xarm_emergency {
inline constexpr std::uint16_t kLinkLost = 0x7500;         ///< XarmProblem
inline constexpr std::uint16_t kTakenOver = 0x9000;        ///< its state, its mode
inline constexpr std::uint16_t kControllerError = 0xFF00;  ///< its error, its warning
inline constexpr std::uint16_t kRefused = 0xFF01;          ///< the register, the state byte
}  // namespace xarm_emergency

enum class XarmPhase : std::uint8_t {
  kConnecting,  ///< now, or again after `retry`
  kAsking,      ///< who it is, whether it has errors, where its joints stand
  kIdle,        ///< the nodes may be enabled
  kEnabling,    ///< motion enable, mode 4, state 0, until a report says so
  kOperating,
  kDoubting,  ///< at work it was stopped or has an error: which? No velocity is sent
  kStopping,  ///< no node is enabled: to rest, then state 4
  kFaulted,   ///< silent until the host asks for a fault reset; then it connects afresh
  kRefused,   ///< not a controller to work with; final
};
const char* Name(XarmPhase phase);

/// A UFACTORY controller of a 7-joint arm, on the bus as seven CiA 402 nodes in cyclic synchronous
/// velocity mode. UFACTORY has no such interface; carrying it so is an adaptation of this project.
///
/// The nodes boot when the controller has reported where its joints stand. When one is told to
/// enable operation, the controller is enabled, and the node when a report confirms it. At each
/// SYNC, or every `resend` without, one request carries what the seven drives want: their targets,
/// slowed before the soft limits, zero of those not enabled. A node's acceleration is not limited
/// here (60C5h is beyond any joint's): that is the controller's.
///
/// What stops the arm, beside the nodes' own deadlines:
///   reports stay away, a connection ends, an answer stays away   0x7500, velocity 0 if it can be
///   mode or state changed by somebody else                       0x9000, not a word more
///   an error of the controller                                   0xFF00
///   a request refused                                            0xFF01
/// on all nodes. A fault is reset in two steps, as its cause is the controller: the first rising
/// bit 7 has it asked afresh (and its error cleaned), and one after that is granted. Lost while
/// nothing was enabled, it is connected to again by itself.
///
///   XarmGateway gateway(config, port);
///   while (running) gateway.Step(now);  // each ms
class XarmGateway {
 public:
  /// `bus` outlives this. assert: the configuration is valid.
  XarmGateway(const XarmGatewayConfig& config, Port& bus);

  void Step(Time now);
  /// Before it ends: an arm at work is told to rest and to stop, and the host that it was, by
  /// 0x7500. Some more Steps carry it to both.
  void Stop(Time now);

  XarmPhase phase() const { return phase_; }
  /// Why it is kRefused or kFaulted, or does not connect; in words, for people.
  const std::string& trouble() const { return trouble_; }
  const std::optional<XarmVersion>& version() const { return version_; }
  const Cia402Node& node(int joint) const { return nodes_[joint]; }  ///< 0-based
  const XarmClient& client() const { return client_; }
  const std::optional<XarmReport>& report() const { return report_; }

  struct Counters {
    std::uint64_t reports = 0;
    std::uint64_t velocities = 0;  ///< requests
    std::uint64_t faults = 0;
    std::uint64_t connections = 0;
    std::uint64_t send_failures = 0;  ///< frames that the bus did not take
    Duration silence_max{};           ///< between reports
  };
  const Counters& counters() const { return counters_; }

 private:
  void Enter(XarmPhase phase, Time now);
  void Connect(Time now);
  void Ask(const XarmFrame& request, Time now);
  void Refuse(const std::string& why);
  void Fault(std::uint16_t emcy, std::uint32_t vendor, const std::string& why, Time now);
  void RaiseOnAll(std::uint16_t emcy, std::uint32_t vendor);
  void AskForRest(Time now);
  void LoseLink(XarmProblem problem, Time now);
  void FaultByErrors(const XarmErrors& errors, Time now);

  void ReadController(Time now);
  void OnReport(const XarmReport& report, Time now);
  void Confirm(const XarmReport& report, Time now);
  void Measure(const XarmReport& report, Time now);
  void OnAnswer(const XarmFrame& answer, Time now);
  void OnAnswerAsking(const XarmFrame& answer, Time now);
  void OnAnswerEnabling(const XarmFrame& answer, Time now);
  void OnAnswerAtWork(const XarmFrame& answer, Time now);
  void OnVersion(const XarmFrame& answer, Time now);
  void Doubt(Time now);
  void BeIdle(Time now);

  void ReadBus(Time now);
  void StepPhase(Time now);
  void StepConnecting(Time now);
  void StepIdle(Time now);
  void StepEnabling(Time now);
  void StepStopping(Time now);
  void StepNodes(Time now);
  void SendVelocities(Time now);
  bool AnyWaits() const;
  bool AnyAtWork() const;
  bool AtWork() const;

  XarmGatewayConfig config_;
  Port& bus_;
  XarmClient client_;
  std::vector<Cia402Node> nodes_;
  std::vector<can::Frame> outbox_;
  XarmPhase phase_ = XarmPhase::kConnecting;
  Time since_{};         ///< of the phase
  bool trying_ = false;  ///< to connect
  Time next_try_{};
  std::string trouble_;
  std::optional<XarmVersion> version_;

  struct Sample {
    Time at{};
    XarmVector position_rad;
  };
  static constexpr int kSamples = 5;
  std::optional<XarmReport> report_;
  std::optional<XarmVector> velocity_radps_;  ///< measured
  FixedVector<Sample, kSamples> samples_;     ///< of this connection
  Time heard_{};                              ///< the last report

  bool held_ = false;         ///< the nodes have a fault of ours
  bool reset_asked_ = false;  ///< by the host: errors may be cleaned
  bool fit_ = false;          ///< the controller is one to work with
  bool cleaned_ = false;
  bool asked_all_ = false;
  int confirming_ = -1;  ///< reports since the answer that they are to confirm; -1: it did not come
  bool stop_sent_ = false;
  bool synced_ = false;
  Time last_velocity_{};
  Time last_poll_{};
  Counters counters_;
};

}  // namespace pipewright::hil

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "hil/devices/csv_drive.h"
#include "hil/devices/object_dictionary.h"
#include "hil/devices/pdo.h"
#include "platform/can/cia402.h"
#include "platform/core/time.h"

namespace pipewright::hil {

/// One joint of the arm. The real UF7 has no public CAN interface: carrying it as CiA 402 nodes is
/// an adaptation of this project.
struct Cia402Config {
  int node_id = 1;           ///< 1 to 127
  double lower_rad = -6.28;  ///< soft limits (607Dh); inside the hard stops
  double upper_rad = 6.28;
  double velocity_max_radps = 3.14159265358979;
  double accel_radps2 = 20.0;
  double quick_stop_radps2 = 10.0;
  Duration boot_time = std::chrono::milliseconds(50);
  /// Whether the host may widen 607Dh, raise 6080h, brake less (6085h), and have a lost connection
  /// ignored: 1400h:5 of 0 or more than 1000 ms, 6007h of 0.
  bool host_may_loosen = true;

  bool Valid() const;
};

using can::NmtState;

/// A CiA 301/402 servo drive, emulated or a real one that something else moves: NMT slave, SDO
/// server (expedited), two receive and two transmit PDOs with dynamic mapping, heartbeat producer
/// and consumer, EMCY, CSV mode. User units 1e-6 rad and 1e-6 rad/s.
///
/// Communication lost while operation is enabled (host heartbeat, 1016h: EMCY 0x8130; no RPDO1
/// taken over for 1400h:5 ms: EMCY 0x8250; NMT leaves operational: EMCY 0x8100): option 6007h, by
/// default the fault reaction. Powered up, every PDO but TPDO2 is disabled until configured.
///
/// It boots when its position has been measured for the first time, and not before.
///
/// 1400h:5 (100 ms at power-up) holds for a host without PDOs, too: a joint that follows a target
/// other than zero, and is given no 6040h or 60FFh by SDO or PDO for so long, has lost its RPDO.
/// Where the host sets it to 0, only the heartbeat it asked for in 1016h stops a joint it forgot.
class Cia402Node {
 public:
  explicit Cia402Node(const Cia402Config& config);

  /// Any frame of the bus; not for us or malformed: ignored, counted when it was ours.
  void OnFrame(const can::Frame& frame, Time now);

  /// Where the joint stands now: what a SYNC samples. Call before this step's frames. What is not
  /// finite is no measurement. Where no velocity is measured, the drive's own is told.
  void Measure(double position_rad, std::optional<double> velocity_radps = {});

  /// Moves the drive to `now` and appends what is due on the wire. Call with steps of at most a
  /// few ms.
  void Step(Time now, std::vector<can::Frame>& out);

  /// The joint's velocity until the next step, as the drive wants it [rad/s].
  double velocity_radps() const { return drive_.velocity_radps(); }

  /// A fault inside the drive (over-current and so on): EMCY with this code and these manufacturer
  /// bytes, then the fault reaction. Persists until cleared, over resets of the node, too.
  void RaiseInternalFault(std::uint16_t emcy_code, std::uint32_t vendor = 0);
  void ClearInternalFault();

  /// As CsvDrive has them.
  void PermitOperation(bool permitted) { drive_.PermitOperation(permitted); }
  bool waits() const { return drive_.waits(); }
  bool reset_asked() const { return drive_.reset_asked(); }

  NmtState nmt() const { return nmt_; }
  DriveState drive_state() const { return drive_.state(); }
  const ObjectDictionary& dictionary() const { return dictionary_; }
  int rejected() const { return rejected_; }

 private:
  void ResetApplication();
  void ResetCommunication();
  void ConfigurePdos();
  void OnNmt(const can::Nmt& request);
  void OnSync(Time now);
  void OnSdo(const can::Sdo& request);
  void OnHeartbeat(int node, Time now);
  void OnReceivePdo(ReceivePdo& receive, const can::Frame& frame, Time now);
  void Apply(ReceivePdo& receive, std::uint64_t payload, Time now);
  void SetNmt(NmtState state);
  AbortCode Write(std::uint16_t index, std::uint8_t sub, int bytes, std::uint32_t value);
  void OnWritten(std::uint16_t index, std::uint8_t sub);
  void LoseConnection(std::uint32_t emcy_code);
  void NoteError(std::uint32_t emcy_code, std::uint32_t register_bits, std::uint32_t vendor = 0);
  void SendEmergency(std::uint32_t code, std::uint32_t vendor = 0);
  void ClearErrors();
  void CheckDeadlines(Time now);
  bool OrdersLate(Time now) const;
  void SendHeartbeat(Time now);
  void PublishState();
  void Send(TransmitPdo& transmit, Time now);
  void SendEventPdos(Time now);
  /// Rows of the bus's table stop at its last joint; a drive may have any id.
  template <typename Row, typename Msg>
  void Queue(Row row, const Msg& msg) {
    row.head.max_node = 127;
    const Result<can::Frame> frame = can::Encode(row, msg, config_.node_id);
    if (frame.ok()) {
      outbox_.push_back(*frame);
    }
  }
  bool ModeIsCsv() const;

  Cia402Config config_;
  ObjectDictionary dictionary_;
  CsvDrive drive_;
  std::vector<ReceivePdo> receive_;
  std::vector<TransmitPdo> transmit_;
  NmtState nmt_ = NmtState::kBootUp;
  std::vector<can::Frame> outbox_;
  std::optional<Time> boot_at_;
  Time last_{};
  bool stepped_ = false;
  std::optional<Time> next_heartbeat_;
  std::optional<Time> host_seen_;
  Time heard_{};                 ///< the last frame
  std::optional<Time> ordered_;  ///< 6040h or 60FFh was written, in whatever way
  bool host_lost_ = false;
  bool measured_ = false;
  double position_rad_ = 0;
  std::optional<double> velocity_radps_;  ///< measured
  std::uint16_t internal_fault_ = 0;
  std::uint32_t internal_vendor_ = 0;
  int rejected_ = 0;
};

}  // namespace pipewright::hil

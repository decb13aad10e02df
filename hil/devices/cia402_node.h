// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "hil/devices/csv_drive.h"
#include "hil/devices/object_dictionary.h"
#include "hil/devices/pdo.h"
#include "platform/can/frame.h"
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

  bool Valid() const;
};

/// NMT states as the heartbeat says them.
enum class NmtState : std::uint8_t {
  kInitialising = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
};

/// A CiA 301/402 servo drive: NMT slave, SDO server (expedited), two receive and two transmit PDOs
/// with dynamic mapping, heartbeat producer and consumer, EMCY, CSV mode. User units 1e-6 rad and
/// 1e-6 rad/s.
///
/// Communication lost while operation is enabled (host heartbeat, 1016h: EMCY 0x8130; no RPDO1
/// taken over for 1400h:5 ms: EMCY 0x8250; NMT leaves operational): option 6007h, by default the
/// fault reaction. Powered up, every PDO but TPDO2 is disabled until configured.
class Cia402Node {
 public:
  explicit Cia402Node(const Cia402Config& config);

  /// Any frame of the bus; not for us or malformed: ignored, counted when it was ours.
  void OnFrame(const can::Frame& frame, Time now);

  /// Moves to `now`; the joint stands at position_rad, measured. Appends what is due on the wire.
  void Step(Time now, double position_rad, std::vector<can::Frame>& out);

  /// The joint's velocity until the next step [rad/s].
  double velocity_radps() const { return drive_.velocity_radps(); }

  /// A fault inside the drive (over-current and so on): EMCY with this code, then the fault
  /// reaction. Persists until cleared.
  void RaiseInternalFault(std::uint16_t emcy_code);
  void ClearInternalFault();

  NmtState nmt() const { return nmt_; }
  DriveState drive_state() const { return drive_.state(); }
  const ObjectDictionary& dictionary() const { return dictionary_; }
  int rejected() const { return rejected_; }

 private:
  void ResetApplication();
  void ResetCommunication();
  void OnNmt(const can::Frame& frame);
  void OnSync(Time now);
  void OnSdo(const can::Frame& frame);
  void OnHostHeartbeat(const can::Frame& frame, Time now);
  void OnReceivePdo(int pdo, const can::Frame& frame, Time now);
  void ApplyReceivePdo(int pdo, Time now);
  void SetNmt(NmtState state);
  Abort Write(std::uint16_t index, std::uint8_t sub, std::uint32_t value);
  void OnWritten(std::uint16_t index, std::uint8_t sub);
  void CommunicationLost(std::uint16_t emcy_code);
  void RaiseFault(std::uint16_t emcy_code, std::uint8_t register_bits);
  void SendEmcy(std::uint16_t code);
  void CheckDeadlines(Time now);
  void MoveDrive(double dt_s, double position_rad);
  void PublishFeedback(double position_rad);
  void SendTransmitPdo(int pdo);
  void SendEventPdos(Time now);
  void Queue(std::uint32_t id, int dlc, std::uint64_t little_endian_payload);

  Cia402Config config_;
  ObjectDictionary dictionary_;
  CsvDrive drive_;
  std::array<ReceivePdo, 2> receive_;
  std::array<TransmitPdo, 2> transmit_;
  NmtState nmt_ = NmtState::kInitialising;
  std::vector<can::Frame> outbox_;
  std::optional<Time> started_;
  Time last_{};
  Time next_heartbeat_{};
  std::optional<Time> host_seen_;
  std::optional<Time> command_seen_;
  double position_rad_ = 0;
  std::uint16_t internal_fault_ = 0;
  std::uint8_t error_register_ = 0;
  int rejected_ = 0;
};

}  // namespace pipewright::hil

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "hil/cli/run_port.h"
#include "hil/devices/port.h"
#include "platform/linux/socket_can.h"

namespace pipewright::hil {

/// The devices' socket on an interface of the kernel, which counts what passes. Error frames of the
/// controller are counted and kept from the devices. One thread's.
class WirePort final : public Port {
 public:
  WirePort(std::string interface, int bitrate)
      : interface_(std::move(interface)), bitrate_(bitrate), load_(bitrate) {}

  /// @returns an error that names the interface and the reason, or nothing
  std::string Open(const std::string& option);

  void Discard() { socket_.Discard(); }
  Status Send(const can::Frame& frame) override;
  bool Receive(can::Frame& frame) override;

  const std::string& interface() const { return interface_; }
  int bitrate() const { return bitrate_; }
  const SocketCan& socket() const { return socket_; }
  /// Of the busiest second of all that passed, at bitrate(); a wire of 1 would be full.
  double load_peak() const { return load_.Peak(); }
  std::uint64_t emergencies() const { return emergencies_; }  ///< EMCY of the arm's nodes
  std::uint64_t error_frames() const { return error_frames_; }
  std::uint64_t bus_offs() const { return bus_offs_; }  ///< of them
  int link_losses() const { return link_losses_; }      ///< times that the interface went down
  /// The interface was taken out of the system.
  bool gone() const;

 private:
  void NoteHealth();

  std::string interface_;
  int bitrate_;
  SocketCan socket_;
  LoadMeter load_;
  std::uint64_t emergencies_ = 0;
  std::uint64_t error_frames_ = 0;
  std::uint64_t bus_offs_ = 0;
  int link_losses_ = 0;
  bool healthy_ = true;
};

}  // namespace pipewright::hil

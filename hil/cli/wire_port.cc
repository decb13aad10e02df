// SPDX-License-Identifier: MIT
#include "hil/cli/wire_port.h"

#include <fmt/format.h>
#include <linux/can/error.h>

#include <cerrno>

#include "platform/can/cia402.h"
#include "platform/linux/clock.h"

namespace pipewright::hil {

std::string WirePort::Open(const std::string& option) {
  if (socket_.Open(interface_) == Status::kOk) {
    return "";
  }
  return fmt::format("{} {}: cannot open the interface: {}", option, interface_,
                     socket_.error_text());
}

Status WirePort::Send(const can::Frame& frame) {
  const Status status = socket_.Send(frame);
  NoteHealth();
  if (status == Status::kOk) {
    can::Frame sent = frame;
    sent.stamp = Now();
    load_.Add(sent);
    emergencies_ += can::NodeOf(can::kEmergency.head, frame.id) > 0 ? 1 : 0;
  }
  return status;
}

bool WirePort::Receive(can::Frame& frame) {
  while (socket_.Receive(frame)) {
    NoteHealth();
    if (!frame.error) {
      load_.Add(frame);
      return true;
    }
    ++error_frames_;
    bus_offs_ += (frame.id & CAN_ERR_BUSOFF) != 0 ? 1 : 0;
  }
  NoteHealth();
  return false;
}

void WirePort::NoteHealth() {
  if (healthy_ && !socket_.healthy()) {
    ++link_losses_;
  }
  healthy_ = socket_.healthy();
}

bool WirePort::gone() const {
  const int error = socket_.error_number();
  return !socket_.healthy() && (error == ENODEV || error == ENXIO);
}

}  // namespace pipewright::hil

// SPDX-License-Identifier: MIT
#include "platform/can/loopback_bus.h"

#include <algorithm>
#include <cassert>

#include "platform/can/bits.h"

namespace pipewright::can {
namespace {

/// The bits that arbitrate, first on the wire highest: the frame with the smaller value goes on.
std::uint32_t Arbitration(const Frame& frame) {
  const std::uint32_t remote = frame.remote ? 1 : 0;
  if (frame.extended) {
    return (frame.id >> 18) << 21 | 3U << 19 | (frame.id & 0x3FFFF) << 1 | remote;
  }
  return frame.id << 21 | remote << 20;
}

bool CanExist(const Frame& frame) {
  return !frame.error && frame.dlc <= 8 && frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
}

}  // namespace

Status LoopbackBus::Port::Send(const Frame& frame) {
  if (!CanExist(frame) || listener_) {
    return Status::kMalformed;
  }
  if (cut_) {
    ++counters_.tx_dropped;
    return Status::kUnavailable;
  }
  if (!tx_.Push(frame)) {
    ++counters_.tx_dropped;
    return Status::kFull;
  }
  return Status::kOk;
}

bool LoopbackBus::Port::Receive(Frame& frame) {
  if (rx_.empty()) {
    return false;
  }
  frame = rx_.Front();
  rx_.Pop();
  return true;
}

void LoopbackBus::Port::SetCut(bool cut) {
  if (cut && !cut_) {
    counters_.tx_dropped += static_cast<std::uint64_t>(tx_.size());
    tx_.Clear();
    ++cuts_;
  }
  cut_ = cut;
}

LoopbackBus::LoopbackBus(int bitrate, Time start)
    : bitrate_(bitrate), now_(start), wire_free_(start), slot_start_(start) {
  assert(bitrate > 0);
}

LoopbackBus::Port* LoopbackBus::Attach() {
  return port_count_ < kMaxPorts ? &ports_[port_count_++] : nullptr;
}

LoopbackBus::Port* LoopbackBus::AttachListener() {
  Port* port = Attach();
  if (port != nullptr) {
    port->listener_ = true;
  }
  return port;
}

void LoopbackBus::AdvanceTo(Time now) {
  if (now <= now_) {
    return;
  }
  // A frame starts before `now` or waits for the next call: one that is queued at `now` itself must
  // still be able to win the wire.
  while (true) {
    if (sender_ >= 0) {
      if (wire_free_ > now) {
        break;
      }
      Complete();
    }
    const int winner = Winner();
    const Time start = std::max(wire_free_, now_);
    if (winner < 0 || start >= now) {
      break;
    }
    Begin(winner, start);
  }
  CloseLoadSlots(sender_ >= 0 ? frame_start_ : now);
  now_ = now;
}

void LoopbackBus::Begin(int port, Time start) {
  sender_ = port;
  sender_cuts_ = ports_[port].cuts_;
  under_way_ = ports_[port].tx_.Front();
  frame_start_ = start;
  const std::int64_t bits = FrameBits(under_way_);
  wire_free_ = start + Duration(bits * 1'000'000'000 / bitrate_);
}

void LoopbackBus::Complete() {
  AddBusy(frame_start_, wire_free_);
  Port& sender = ports_[sender_];
  if (sender.cuts_ == sender_cuts_) {
    if (Acknowledged(sender_)) {
      sender.tx_.Pop();
      ++sender.counters_.tx;
      ++frames_;
      Deliver(sender_);
    } else {
      ++unacknowledged_;
    }
  }
  sender_ = -1;
}

int LoopbackBus::Winner() const {
  int winner = -1;
  std::uint32_t lowest = 0;
  for (int i = 0; i < port_count_; ++i) {
    if (ports_[i].tx_.empty()) {
      continue;
    }
    const std::uint32_t key = Arbitration(ports_[i].tx_.Front());
    if (winner < 0 || key < lowest) {
      winner = i;
      lowest = key;
    }
  }
  return winner;
}

bool LoopbackBus::Acknowledged(int sender) const {
  for (int i = 0; i < port_count_; ++i) {
    if (i != sender && !ports_[i].cut_ && !ports_[i].listener_) {
      return true;
    }
  }
  return false;
}

void LoopbackBus::Deliver(int sender) {
  under_way_.stamp = wire_free_;
  for (int i = 0; i < port_count_; ++i) {
    Port& port = ports_[i];
    if (i == sender || port.cut_) {
      continue;
    }
    ++(port.rx_.Push(under_way_) ? port.counters_.rx : port.counters_.rx_dropped);
  }
}

void LoopbackBus::AddBusy(Time from, Time to) {
  CloseLoadSlots(from);
  while (to > slot_start_ + kLoadSlot) {
    const Time slot_end = slot_start_ + kLoadSlot;
    busy_[slot_] += slot_end - from;
    from = slot_end;
    CloseLoadSlots(from);
  }
  busy_[slot_] += to - from;
}

void LoopbackBus::CloseLoadSlots(Time until) {
  while (slot_start_ + kLoadSlot <= until) {
    busy_sum_ += busy_[slot_];
    busy_second_ = busy_sum_;
    busy_peak_ = std::max(busy_peak_, busy_second_);
    slot_ = (slot_ + 1) % kLoadSlots;
    busy_sum_ -= busy_[slot_];
    busy_[slot_] = {};
    slot_start_ += kLoadSlot;
  }
}

double LoopbackBus::Load() const { return ToSeconds(busy_second_); }

double LoopbackBus::PeakLoad() const { return ToSeconds(busy_peak_); }

}  // namespace pipewright::can

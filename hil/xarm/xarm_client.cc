// SPDX-License-Identifier: MIT
#include "hil/xarm/xarm_client.h"

#include <algorithm>

namespace pipewright::hil {
namespace {

/// Takes the first of what came, for one that is full.
template <typename T, int kCapacity>
void DropFirst(FixedVector<T, kCapacity>& items, int at = 0) {
  std::copy(items.begin() + at + 1, items.end(), items.begin() + at);
  items.pop_back();
}

template <typename T, int kCapacity>
bool TakeFirst(FixedVector<T, kCapacity>& items, T& item) {
  if (items.empty()) {
    return false;
  }
  item = items[0];
  DropFirst(items);
  return true;
}

}  // namespace

const char* Name(XarmProblem problem) {
  switch (problem) {
    case XarmProblem::kNone:
      return "none";
    case XarmProblem::kUnreachable:
      return "a connection was refused";
    case XarmProblem::kConnectTimeout:
      return "nobody took the connection";
    case XarmProblem::kClosed:
      return "a connection ended";
    case XarmProblem::kMalformed:
      return "bytes that are no frame and no report";
    case XarmProblem::kNoAnswer:
      return "a request was not answered";
    case XarmProblem::kSilent:
      return "no report came";
  }
  return "?";
}

void XarmClient::Connect(Time now) {
  Close();
  problem_ = XarmProblem::kNone;
  wanted_ = true;
  was_up_ = false;
  connect_since_ = now;
  if (requests_.Connect(config_.address, config_.request_port) != Status::kOk ||
      reports_.Connect(config_.address, config_.report_port) != Status::kOk) {
    Fail(XarmProblem::kUnreachable);
  }
}

void XarmClient::Close() {
  wanted_ = false;
  requests_.Close();
  reports_.Close();
  waiting_.clear();
  answers_.clear();
  fresh_.clear();
}

void XarmClient::Fail(XarmProblem problem) {
  Close();
  problem_ = problem;
}

void XarmClient::Step(Time now) {
  if (!wanted_) {
    return;
  }
  requests_.Poll();
  reports_.Poll();
  was_up_ = was_up_ || up();
  ReadAnswers();
  ReadReports();
  CheckConnections(now);
}

void XarmClient::CheckConnections(Time now) {
  if (!wanted_) {
    return;  // closed meanwhile
  }
  const bool gone =
      !(requests_.open() || requests_.connecting()) || !(reports_.open() || reports_.connecting());
  if (gone) {
    Fail(was_up_ ? XarmProblem::kClosed : XarmProblem::kUnreachable);
  } else if (connecting() && now - connect_since_ > config_.connect_timeout) {
    Fail(XarmProblem::kConnectTimeout);
  } else if (!waiting_.empty() && now - waiting_[0].since > config_.answer_timeout) {
    Fail(XarmProblem::kNoAnswer);
  }
}

void XarmClient::ReadAnswers() {
  while (wanted_) {
    const Result<std::size_t> size = XarmFrameBytes(requests_.received());
    if (!size.ok()) {
      return Fail(XarmProblem::kMalformed);
    }
    if (*size == 0 || *size > requests_.received().size()) {
      return;
    }
    const Result<XarmFrame> answer = DecodeXarmFrame(requests_.received().first(*size));
    requests_.Take(*size);
    if (answer.ok()) {
      OnAnswer(*answer);
    }
  }
}

void XarmClient::OnAnswer(const XarmFrame& answer) {
  const auto asked = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
    return w.transaction == answer.transaction && w.register_number == answer.register_number;
  });
  // The first payload byte is the state: an answer without one says nothing.
  if (answer.protocol != XarmFrame::kPrivateProtocol || asked == waiting_.end() ||
      answer.size == 0 || !answers_.push_back(answer)) {
    ++strays_;
    return;
  }
  DropFirst(waiting_, static_cast<int>(asked - waiting_.begin()));
}

void XarmClient::ReadReports() {
  while (wanted_) {
    const Result<std::size_t> size = XarmReportBytes(config_.report, reports_.received());
    if (!size.ok()) {
      return Fail(XarmProblem::kMalformed);
    }
    if (*size == 0 || *size > reports_.received().size()) {
      return;
    }
    const Result<XarmReport> report =
        DecodeXarmReport(config_.report, reports_.received().first(*size));
    reports_.Take(*size);
    if (!report.ok()) {
      ++bad_reports_;
      continue;
    }
    if (fresh_.full()) {
      DropFirst(fresh_);
    }
    (void)fresh_.push_back(*report);
  }
}

Status XarmClient::Ask(XarmFrame request, Time now) {
  if (!up()) {
    return Status::kUnavailable;
  }
  if (waiting_.size() + answers_.size() >= kUnderWay) {
    return Status::kFull;
  }
  transaction_ = static_cast<std::uint16_t>(transaction_ % 0xFFFF + 1);
  request.transaction = transaction_;
  std::array<std::uint8_t, XarmFrame::kBytesMax> room{};
  if (!requests_.Send({room.data(), EncodeXarmFrame(request, room)})) {
    Fail(XarmProblem::kClosed);
    return Status::kFault;
  }
  ++asked_;
  (void)waiting_.push_back({transaction_, request.register_number, now});
  return Status::kOk;
}

bool XarmClient::TakeAnswer(XarmFrame& answer) { return TakeFirst(answers_, answer); }

bool XarmClient::TakeReport(XarmReport& report) { return TakeFirst(fresh_, report); }

}  // namespace pipewright::hil

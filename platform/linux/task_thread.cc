// SPDX-License-Identifier: MIT
#include "platform/linux/task_thread.h"

#include <cstdio>

namespace pipewright {
namespace {

constexpr int kNameBytes = 16;  // the kernel's, its end included

}  // namespace

void* TaskThread::Run(void* self) {
  const auto* thread = static_cast<const TaskThread*>(self);
  thread->work_(thread->context_);
  return nullptr;
}

Status TaskThread::Start(const char* name, Work work, void* context) {
  if (started_) {
    return Status::kFull;
  }
  work_ = work;
  context_ = context;
  if (pthread_create(&thread_, nullptr, &TaskThread::Run, this) != 0) {
    return Status::kUnavailable;
  }
  started_ = true;
  char short_name[kNameBytes];
  std::snprintf(short_name, sizeof short_name, "%s", name);
  pthread_setname_np(thread_, short_name);  // a name that is refused hurts nobody
  return Status::kOk;
}

void TaskThread::Join() {
  if (started_) {
    pthread_join(thread_, nullptr);
    started_ = false;
  }
}

}  // namespace pipewright

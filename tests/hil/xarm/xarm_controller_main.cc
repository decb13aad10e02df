// SPDX-License-Identifier: MIT
// An emulated UFACTORY controller on 127.0.0.1 at a controller's own ports, in real time, until it
// is ended: for tests/vm, and for a client of the vendor's.
#include <cstdio>

#include "hil/xarm/xarm_controller.h"
#include "platform/linux/clock.h"

int main() {
  using namespace pipewright;
  hil::XarmController controller({.request_port = 502,
                                  .real_port = ReportPort(hil::XarmReportKind::kReal),
                                  .real_time_port = ReportPort(hil::XarmReportKind::kRealTime)});
  if (const std::string error = controller.Open(); !error.empty()) {
    std::fprintf(stderr, "xarm_controller: %s\n", error.c_str());
    return 1;
  }
  std::puts("xarm_controller: listening");
  std::fflush(stdout);
  for (PeriodicTimer tick(std::chrono::milliseconds(1));;) {
    controller.Step(tick.Wait());
  }
}

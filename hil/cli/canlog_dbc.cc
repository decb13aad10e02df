// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_dbc.h"

#include "hil/canlog/dbc.h"
#include "hil/cli/canlog_signals.h"

namespace pipewright::hil {

int CanlogDbc(LogSet&, const CanlogOptions& options) {
  if (!options.files.empty()) {
    return Refuse("dbc: takes no log: a DBC file holds what frames mean, not frames");
  }
  const DbcDevices devices = options.device == "tracer" ? DbcDevices::kTracer
                             : options.device == "uf7"  ? DbcDevices::kArm
                                                        : DbcDevices::kBoth;
  return Print(DbcText(devices, ControlModesNamed(options.modes)));
}

}  // namespace pipewright::hil

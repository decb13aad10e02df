// SPDX-License-Identifier: MIT
#include "hil/cli/canlog_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "hil/cli/canlog_dbc.h"
#include "hil/cli/canlog_decode.h"
#include "hil/cli/canlog_diff.h"
#include "hil/cli/canlog_export.h"
#include "hil/cli/canlog_gaps.h"
#include "hil/cli/canlog_input.h"
#include "hil/cli/canlog_load.h"
#include "hil/cli/canlog_stats.h"
#include "hil/replay/depth_recording.h"

namespace pipewright::hil {
namespace {

using Work = int (*)(LogSet&, const CanlogOptions&);

/// Reads two logs of its own.
int Diff(LogSet&, const CanlogOptions& options) { return CanlogDiff(options); }

int Run(const CanlogOptions& options, Work work) {
  CanlogInput input;
  if (const std::string error = input.Open(options); !error.empty()) {
    return Refuse(error);
  }
  return work(input.log(), options);
}

void AddCommonOptions(CLI::App& command, CanlogOptions& options) {
  command.add_option("FILE", options.files,
                     "logs, read one after the other as parts of one; - is standard input");
  command
      .add_option("--id", options.ids,
                  "only frames with these ids, hex: 211, a range 180-1FF, an id and a mask\n"
                  "180/780, several apart by commas; `error`: error messages. Up to 3 digits\n"
                  "mean 11-bit ids, more mean 29-bit ones")
      ->allow_extra_args(false);  // the next word may be a file
  command.add_option("--from", options.from,
                     "only frames from then on: seconds from the log's first frame, or behind an\n"
                     "@ seconds of its own clock");
  command.add_option("--to", options.to, "only frames up to then, likewise");
  command.add_flag("--deltas", options.deltas,
                   "the times of a candump log are those between frames, as candump -t d writes;\n"
                   "without this, taken so when many stamps are below the one before");
  command
      .add_option("--bitrate", options.bitrate,
                  "bit/s of every channel, for its load; stuff bits are counted as they are")
      ->check(CLI::Range(1e3, 1e8));
  command
      .add_option("--signal", options.signals,
                  "only these signals of `decode` and `export`, several apart by commas: a frame\n"
                  "(base_state), a signal (battery), or a path (tpdo1_joint_feedback/3/position);\n"
                  "* stands for any characters")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option("--modes", options.modes,
                  "what base_state's control modes mean: by the\n"
                  "vendor's sdk, or by the manual of the tracer1, tracer2 or mini")
      ->check(CLI::IsMember({"sdk", "tracer1", "tracer2", "mini"}))
      ->capture_default_str();
  command.add_flag("--json", options.json, "print one object, and nothing else, on stdout");
}

void AddExportOptions(CLI::App& command, CanlogOptions& options) {
  command
      .add_option("--every", options.every_s,
                  "a row every so many s, with what was sent last; without this, a row for each\n"
                  "time at which something was sent, and cells empty of what was not")
      ->check(CLI::Range(1e-6, 1e6));
  CLI::Option* const mcap = command.add_option(
      "--mcap", options.mcap,
      "instead, write an MCAP file of ROS 2 messages, for Foxglove, Rerun and PlotJuggler:\n"
      "/joint_states, /joint_commands, /odom and /tf (by the robot's wheel odometry),\n"
      "/cmd_vel, /diagnostics");
  CLI::Option* const depth =
      command
          .add_option("--depth", options.depth,
                      fmt::format("with --mcap: the depth frames of the same run, too ({} of\n"
                                  "`inspect --record-depth`): /camera/points, and in /tf where\n"
                                  "the camera is on the robot",
                                  kDepthFileName))
          ->needs(mcap);
  command
      .add_option("--points-every", options.points_every,
                  "with --depth: every so many-th pixel each way. 640x480 of them are 3.7 MB a\n"
                  "frame unpacked; 2, as the robot's own map takes them, a quarter of that")
      ->needs(depth)
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
}

/// The words of the command; the one that is given sets `work`.
void AddWords(CLI::App& command, CanlogOptions& options, Work& work) {
  const auto add = [&command, &work](const char* name, const char* what, Work does) {
    CLI::App* const sub = command.add_subcommand(name, what);
    sub->fallthrough();  // options and files may stand behind the word, too
    sub->callback([&work, does] { work = does; });
    return sub;
  };
  add("stats",
      "of all, each channel and each id: frames, rate, periods and their jitter, bytes,\n"
      "first and last time, load. Without any of these words, this",
      CanlogStats);
  add("decode",
      "every frame of the base and of the arm by the names of its signals, in their units,\n"
      "states by their names",
      CanlogDecode)
      ->add_flag("--csv", options.csv, "one line a signal, for other programs");
  CLI::App* const gaps = add(
      "gaps",
      "what should not be: silence of periodic ids, duplicates, counts that jump, the base's\n"
      "command watchdog run out, heartbeats lost, EMCY and error messages, SDOs unanswered (of a\n"
      "node not heard of yet: a note)",
      CanlogGaps);
  gaps->add_option("--factor", options.gap_factor, "a gap is longer than so many periods")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  gaps->add_option("--most", options.most, "findings of each kind to print; all are counted")
      ->capture_default_str();
  CLI::App* const load =
      add("load", "the load of each channel over time, and its peak", CanlogLoad);
  load->add_option("--window", options.window_s, "length of a window, s")
      ->check(CLI::Range(1e-3, 1e6))
      ->capture_default_str();
  load->add_flag("--csv", options.csv, "one line a window, for other programs");
  add("diff",
      "of two logs: where the frames of each id first differ, in their own order and on whatever\n"
      "channel; and how their times do",
      Diff);
  CLI::App* const exports = add(
      "export",
      "the signals of base and arm as one table in CSV, a column a signal, in the order of time:\n"
      "opens in PlotJuggler. Or --mcap",
      CanlogExport);
  AddExportOptions(*exports, options);
  add("dbc",
      "the frames of base and arm as a DBC file, for other programs that look into CAN; takes no\n"
      "log",
      CanlogDbc)
      ->add_option("--device", options.device, "only those of one: tracer or uf7")
      ->check(CLI::IsMember({"tracer", "uf7"}));
}

}  // namespace

void AddCanlog(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "canlog", "Look into a CAN log: figures, frames in words, faults, load, differences");
  const auto options = std::make_shared<CanlogOptions>();
  const auto work = std::make_shared<Work>(CanlogStats);
  AddCommonOptions(*command, *options);
  command->require_subcommand(0, 1);
  AddWords(*command, *options, *work);
  command->final_callback([options, exit_code, work] {
    // Not CLI11's required(): it would take the word for a file.
    if (options->files.empty() && *work != CanlogDbc) {
      throw CLI::RequiredError("FILE");
    }
    *exit_code = Run(*options, *work);
  });
  command->footer(
      "A log is candump -L, what candump prints (also with -t a, -t A, -t z, -t d, -a, -e, -x),\n"
      "Vector ASC, pcap or pcapng of SocketCAN; plain, gz or zstd: its first bytes tell. It may "
      "be\n"
      "of any length: memory does not grow with it. Times of ASC count from the measurement's\n"
      "start. A line or packet that makes no sense is passed over and told on standard error.\n"
      "Exit code: 0 done; 1 a part of the log makes no sense, it or the depth frames break off,\n"
      "`gaps` found something, or `diff` a difference in more than time; 2 the input is bad.\n"
      "Examples: pipewright canlog run/can.log --bitrate 500000\n"
      "          candump -L can0 | pipewright canlog - --json\n"
      "          pipewright canlog run/can.log export --signal position,velocity >joints.csv\n"
      "          pipewright canlog run/can.log export --mcap run.mcap --depth "
      "run/depth.z16.zst\n"
      "          pipewright canlog dbc --device tracer >tracer.dbc");
}

}  // namespace pipewright::hil

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "hil/cli/map_run.h"

namespace pipewright::hil {

/// Results as files, little-endian. A key is a voxel's index plus 32768 per axis, as OctoMap's.
/// @returns what went wrong, in words that name the file; empty: nothing
///
///   map    'MPM1', u32 n; n x { u16 key[3]; f32 log-odds }: every known voxel of the stored box,
///          then of the bricks that have left it
///   hits   'MPH1', u32 n; n x { u16 hit; u16 key_of_end[3] }: twice, first with unknown voxels
///          ending a ray, then without
///   gains  'MPG1', u32 n; n x { u32 unknown, visual hits, uncovered hits, coverage hits }
std::string WriteMapDump(const MapRun& run, const std::filesystem::path& path);
std::string WriteRayHits(const MapRun& run, const std::filesystem::path& path);
std::string WriteViewCounts(const MapRun& run, const std::filesystem::path& path);

}  // namespace pipewright::hil

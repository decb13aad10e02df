// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "platform/core/status.h"

namespace pipewright {

using PrimitiveId = std::int32_t;
using ConfigurationId = std::int32_t;

/// How much a set system may hold.
struct ObservationCapacity {
  int configurations = 0;
  int primitives = 0;  ///< ids are in [0, primitives)
  int incidences = 0;  ///< pairs (q, p) of a configuration q that sees a primitive p
};

/// Which configurations see which primitives: the set system (P, Q) of coverage planning, read both
/// ways. Two lists run through the cell of an incidence (q, p): what q sees, and who sees p.
///
///   page       |      q = 7       |      q = 2       |      q = 7       |  32 cells each
///   cell       |  p  p  p  p ...  |  p  p  p         |  p  p            |  ascending for each q
///   links          next and previous cell of the same p, whose page tells who it is
///
/// What a configuration sees is walked in order through pages, 128 bytes of ids at a time, for that
/// is what covers do most; who sees a primitive is walked from cell to cell. The last page of a
/// list is in part empty; for that, pages are provided beyond the incidences, so that nothing is
/// ever full but a capacity, whatever was added and removed before.
///
/// Ids are handles: a configuration has its own as long as it is there; then another takes it.
///
/// All memory is taken at construction: 12.25 bytes an incidence, 390 a configuration, 8 a
/// primitive. Of 2,000,000 incidences, 5,000 configurations, 100,000 primitives: 26 MiB.
class Observations {
 public:
  class Seen;
  class Observers;

  /// Capacities >= 0, and less than 2³¹ cells: incidences + 32 · configurations.
  explicit Observations(const ObservationCapacity& capacity);

  /// Adds a configuration that sees `seen`, ascending, each once; may be empty. O(|seen|)
  /// @returns its id; without effect otherwise. kOutOfRange: no such primitive; kMalformed: not
  ///   ascending; kFull: no room for the configuration or what it sees
  Result<ConfigurationId> Add(std::span<const PrimitiveId> seen);
  /// What q sees is now this. O(|seen before| + |seen|)
  /// @returns as Add(), and kOutOfRange: no such configuration
  Status Replace(ConfigurationId q, std::span<const PrimitiveId> seen);
  /// O(|seen before|) @returns kOutOfRange: no such configuration
  Status Remove(ConfigurationId q);

  bool Contains(ConfigurationId q) const {
    return 0 <= q && q < capacity_.configurations && seen_count_[q] != kAbsent;
  }
  /// The primitives that q sees, ascending; q is there. Valid until something changes.
  Seen SeenBy(ConfigurationId q) const;
  int SeenCount(ConfigurationId q) const {
    assert(Contains(q));
    return seen_count_[q];
  }
  /// The configurations that see p, the last added or replaced first. Valid until something
  /// changes.
  Observers ObserversOf(PrimitiveId p) const;
  int ObserverCount(PrimitiveId p) const {
    assert(0 <= p && p < capacity_.primitives);
    return observer_count_[p];
  }

  int configurations() const { return configurations_; }
  int incidences() const { return incidences_; }
  const ObservationCapacity& capacity() const { return capacity_; }
  std::size_t MemoryBytes() const;

 private:
  static constexpr int kPageCells = 32;
  static constexpr int kNone = -1;
  static constexpr int kAbsent = -1;

  struct Page {
    std::int32_t next = kNone;  // of the same configuration, or of the free ones
    ConfigurationId owner = kNone;
  };
  struct Links {
    std::int32_t next = kNone;
    std::int32_t previous = kNone;
  };

  Status Check(std::span<const PrimitiveId> seen) const;
  void Take(ConfigurationId q, std::span<const PrimitiveId> seen);
  void Release(ConfigurationId q);
  void Link(int cell, PrimitiveId p);
  void Unlink(int cell);

  ObservationCapacity capacity_;
  int configurations_ = 0;
  int incidences_ = 0;
  int free_page_ = kNone;
  int free_configuration_ = kNone;
  std::vector<PrimitiveId> primitive_;  // by cell
  std::vector<Links> links_;            // by cell
  std::vector<Page> pages_;
  std::vector<std::int32_t> first_page_;  // by configuration; of absent ones, the next absent one
  std::vector<std::int32_t> seen_count_;  // by configuration
  std::vector<std::int32_t> first_cell_;  // by primitive
  std::vector<std::int32_t> observer_count_;
};

/// A range of primitives.
class Observations::Seen {
 public:
  class Iterator {
   public:
    Iterator(const Observations& of, int page, int count)
        : of_(&of), cell_(page * kPageCells), left_(count) {}
    PrimitiveId operator*() const { return of_->primitive_[cell_]; }
    Iterator& operator++() {
      --left_;
      cell_ = (cell_ + 1) % kPageCells != 0 ? cell_ + 1
                                            : of_->pages_[cell_ / kPageCells].next * kPageCells;
      return *this;
    }
    bool operator==(std::default_sentinel_t) const { return left_ == 0; }

   private:
    const Observations* of_;
    int cell_;
    int left_;
  };

  Seen(const Observations& of, ConfigurationId q) : of_(&of), q_(q) {}
  Iterator begin() const { return {*of_, of_->first_page_[q_], of_->seen_count_[q_]}; }
  std::default_sentinel_t end() const { return {}; }

 private:
  const Observations* of_;
  ConfigurationId q_;
};

/// A range of configurations.
class Observations::Observers {
 public:
  class Iterator {
   public:
    Iterator(const Observations& of, int cell) : of_(&of), cell_(cell) {}
    ConfigurationId operator*() const { return of_->pages_[cell_ / kPageCells].owner; }
    Iterator& operator++() {
      cell_ = of_->links_[cell_].next;
      return *this;
    }
    bool operator==(std::default_sentinel_t) const { return cell_ == kNone; }

   private:
    const Observations* of_;
    int cell_;
  };

  Observers(const Observations& of, PrimitiveId p) : of_(&of), p_(p) {}
  Iterator begin() const { return {*of_, of_->first_cell_[p_]}; }
  std::default_sentinel_t end() const { return {}; }

 private:
  const Observations* of_;
  PrimitiveId p_;
};

inline Observations::Seen Observations::SeenBy(ConfigurationId q) const {
  assert(Contains(q));
  return {*this, q};
}

inline Observations::Observers Observations::ObserversOf(PrimitiveId p) const {
  assert(0 <= p && p < capacity_.primitives);
  return {*this, p};
}

}  // namespace pipewright

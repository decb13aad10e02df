// SPDX-License-Identifier: MIT
#include "plan/coverage/observations.h"

#include <limits>

namespace pipewright {

Observations::Observations(const ObservationCapacity& capacity) : capacity_(capacity) {
  // A list of n takes ceil(n / 32) pages, so all take (incidences + 31 · configurations) / 32 at
  // most.
  const std::int64_t cells =
      std::int64_t{capacity.incidences} + std::int64_t{kPageCells - 1} * capacity.configurations;
  assert(cells <= std::numeric_limits<std::int32_t>::max());
  const auto pages = static_cast<std::size_t>(cells / kPageCells);
  primitive_.resize(pages * kPageCells);
  links_.resize(pages * kPageCells);
  pages_.resize(pages);
  first_page_.resize(capacity.configurations, kNone);
  seen_count_.resize(capacity.configurations, kAbsent);
  first_cell_.resize(capacity.primitives, kNone);
  observer_count_.resize(capacity.primitives);
  for (int page = static_cast<int>(pages) - 1; page >= 0; --page) {
    pages_[page].next = free_page_;
    free_page_ = page;
  }
  for (ConfigurationId q = capacity.configurations - 1; q >= 0; --q) {
    first_page_[q] = free_configuration_;
    free_configuration_ = q;
  }
}

Result<ConfigurationId> Observations::Add(std::span<const PrimitiveId> seen) {
  if (const Status status = Check(seen); status != Status::kOk) {
    return status;
  }
  if (free_configuration_ == kNone || std::ssize(seen) > capacity_.incidences - incidences_) {
    return Status::kFull;
  }
  const ConfigurationId q = free_configuration_;
  free_configuration_ = first_page_[q];
  ++configurations_;
  Take(q, seen);
  return q;
}

Status Observations::Replace(ConfigurationId q, std::span<const PrimitiveId> seen) {
  if (!Contains(q)) {
    return Status::kOutOfRange;
  }
  if (const Status status = Check(seen); status != Status::kOk) {
    return status;
  }
  if (std::ssize(seen) > capacity_.incidences - incidences_ + seen_count_[q]) {
    return Status::kFull;
  }
  Release(q);
  Take(q, seen);
  return Status::kOk;
}

Status Observations::Remove(ConfigurationId q) {
  if (!Contains(q)) {
    return Status::kOutOfRange;
  }
  Release(q);
  seen_count_[q] = kAbsent;
  first_page_[q] = free_configuration_;
  free_configuration_ = q;
  --configurations_;
  return Status::kOk;
}

Status Observations::Check(std::span<const PrimitiveId> seen) const {
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k] < 0 || seen[k] >= capacity_.primitives) {
      return Status::kOutOfRange;
    }
    if (k > 0 && seen[k - 1] >= seen[k]) {
      return Status::kMalformed;
    }
  }
  return Status::kOk;
}

void Observations::Take(ConfigurationId q, std::span<const PrimitiveId> seen) {
  const int count = static_cast<int>(seen.size());
  first_page_[q] = free_page_;  // the free pages lie in the order in which they are taken
  int page = kNone;
  for (int k = 0; k < count; ++k) {
    if (k % kPageCells == 0) {
      page = free_page_;
      free_page_ = pages_[page].next;
      pages_[page].owner = q;
    }
    Link(page * kPageCells + k % kPageCells, seen[k]);
  }
  seen_count_[q] = count;
  incidences_ += count;
}

void Observations::Release(ConfigurationId q) {
  int page = first_page_[q];
  int last = kNone;
  for (int k = 0; k < seen_count_[q]; ++k) {
    Unlink(page * kPageCells + k % kPageCells);
    if (k % kPageCells == kPageCells - 1 || k == seen_count_[q] - 1) {
      last = page;
      page = pages_[page].next;
    }
  }
  if (last != kNone) {
    pages_[last].next = free_page_;
    free_page_ = first_page_[q];
  }
  incidences_ -= seen_count_[q];
}

void Observations::Link(int cell, PrimitiveId p) {
  const int next = first_cell_[p];
  primitive_[cell] = p;
  links_[cell] = {.next = next, .previous = kNone};
  if (next != kNone) {
    links_[next].previous = cell;
  }
  first_cell_[p] = cell;
  ++observer_count_[p];
}

void Observations::Unlink(int cell) {
  const PrimitiveId p = primitive_[cell];
  const auto [next, previous] = links_[cell];
  (previous == kNone ? first_cell_[p] : links_[previous].next) = next;
  if (next != kNone) {
    links_[next].previous = previous;
  }
  --observer_count_[p];
}

std::size_t Observations::MemoryBytes() const {
  return primitive_.capacity() * sizeof(PrimitiveId) + links_.capacity() * sizeof(Links) +
         pages_.capacity() * sizeof(Page) +
         (first_page_.capacity() + seen_count_.capacity() + first_cell_.capacity() +
          observer_count_.capacity()) *
             sizeof(std::int32_t);
}

}  // namespace pipewright

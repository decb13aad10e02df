// SPDX-License-Identifier: MIT
#pragma once

#include <sys/un.h>

#include <string>

namespace pipewright::hil {

/// A file descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { Reset(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.number_) { other.number_ = -1; }
  Descriptor& operator=(Descriptor&& other) noexcept;

  bool open() const { return number_ >= 0; }
  int number() const { return number_; }
  void Reset();

 private:
  int number_ = -1;
};

/// The address of a Unix socket. @returns an error in words, or nothing
std::string LocalAddress(const std::string& path, sockaddr_un& address);

/// A stream connected to who listens at `path`.
/// @param error  set, in words, when there is none
Descriptor ConnectLocal(const std::string& path, std::string& error);

}  // namespace pipewright::hil

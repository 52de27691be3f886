#include "tools/hapticctl-import/complaints.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace hapticctl_import {

Complaints::Complaints() {
  std::fflush(stderr);
  file_ = ::memfd_create("complaints", MFD_CLOEXEC);
  terminal_ = ::dup(STDERR_FILENO);
  if (file_ >= 0 && terminal_ >= 0) ::dup2(file_, STDERR_FILENO);
}

Complaints::~Complaints() {
  std::fflush(stderr);
  if (terminal_ >= 0) ::dup2(terminal_, STDERR_FILENO);
  for (const int fd : {file_, terminal_})
    if (fd >= 0) ::close(fd);
}

std::string Complaints::text(std::size_t most) const {
  std::fflush(stderr);
  std::string text(most, '\0');
  const ssize_t size = file_ < 0 ? 0 : ::pread(file_, text.data(), most, 0);
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return text;
}

std::string Complaints::first() const {
  std::string line = text(200);
  line.resize(std::min(line.size(), line.find('\n')));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return line;
}

bool Complaints::hold(const std::string& phrase) const { return text(1 << 16).find(phrase) != std::string::npos; }

}  // namespace hapticctl_import

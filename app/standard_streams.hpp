#pragma once
// What every program of ours does before it opens anything.

#include <fcntl.h>
#include <unistd.h>

namespace trammel {

/// A standard stream that was closed would be the next file or socket that is opened, and get what
/// is meant for a person. What is lost of the data is noticed, what is lost of the talk is not.
inline void hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1) continue;
    const int held = ::open(stream == STDOUT_FILENO ? "/dev/full" : "/dev/null", O_RDWR);
    if (held != stream) ::_exit(1);  // the lowest number is the one that is free
  }
}

}  // namespace trammel

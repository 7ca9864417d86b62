// Preloaded into the daemon (LD_PRELOAD): each fsync takes STYLED_FSYNC_S seconds, as on a disk
// that wakes up or a network mount that reconnects.
#include <time.h>
#include <unistd.h>

#include <cstdlib>

extern "C" int fsync(int /*fd*/) {
  const char* const seconds = std::getenv("STYLED_FSYNC_S");
  const double wait_s = seconds == nullptr ? 0 : std::atof(seconds);
  timespec wait{
      static_cast<time_t>(wait_s),
      static_cast<long>(1e9 * (wait_s - static_cast<double>(static_cast<time_t>(wait_s))))};
  while (nanosleep(&wait, &wait) != 0) {
  }
  return 0;
}

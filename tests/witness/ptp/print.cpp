// styled_clock_print SOCKET: what ClockWatch finds out about the ptp4l there, a line per second
// until it knows; 1 if that is not so within 20 s.
#include <cstdio>
#include <ctime>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/clock_watch.h"

int main(int count, char** words) {
  if (count != 2) return 2;
  styled::runtime::SystemClock clock;
  styled::runtime::ClockWatch watch(words[1]);
  for (int second = 0; second < 20; ++second) {
    watch.Update(clock.Now_ns());
    if (const auto& ptp = watch.discipline().ptp) {
      std::printf(
          "domain %d\nleader %s\nport %s\nsteps %d\npriority1 %d\nclass %d\nsource 0x%02x\n"
          "delay_ns %.0f\n",
          ptp->domain, styled::ptp::Text(ptp->parent.leader).c_str(),
          styled::ptp::Text(ptp->port).c_str(), ptp->current.steps_removed, ptp->parent.priority1,
          ptp->parent.clock_class, ptp->properties.time_source,
          1e9 * ptp->current.mean_path_delay_s);
      return 0;
    }
    const timespec pause{1, 0};
    nanosleep(&pause, nullptr);
  }
  return 1;
}

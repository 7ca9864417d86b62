#include "tests/support/count_new.h"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <new>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COUNT_MALLOC 1
#endif

namespace {

std::atomic<bool> counting{false};
std::atomic<int> calls{0};

void Count() {
  if (counting.load(std::memory_order_relaxed)) calls.fetch_add(1);
}

}  // namespace

#if COUNT_MALLOC

namespace {

// Bytes allocated since counting began, and their peak. Freeing memory from before then makes it
// negative.
std::atomic<std::int64_t> live{0}, peak{0};

void* Counted(void* memory) {
  Count();
  if (memory == nullptr || !counting.load(std::memory_order_relaxed)) return memory;
  const auto bytes = static_cast<std::int64_t>(malloc_usable_size(memory));
  const std::int64_t now = live.fetch_add(bytes) + bytes;
  for (std::int64_t most = peak; now > most && !peak.compare_exchange_weak(most, now);) {
  }
  return memory;
}

void Freed(void* memory) {
  if (memory == nullptr || !counting.load(std::memory_order_relaxed)) return;
  live.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(memory)));
}

}  // namespace

// glibc's names for the functions replaced below; operator new also ends there.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);
// NOLINTEND(bugprone-reserved-identifier)
void* malloc(std::size_t size) { return Counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return Counted(__libc_calloc(count, size)); }
// Counted as if old and new block were there together, as they are while one is copied.
void* realloc(void* memory, std::size_t size) {
  const std::size_t before = memory == nullptr ? 0 : malloc_usable_size(memory);
  void* const taken = Counted(__libc_realloc(memory, size));
  if (counting.load(std::memory_order_relaxed) && (taken != nullptr || size == 0)) {
    live.fetch_sub(static_cast<std::int64_t>(before));
  }
  return taken;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return Counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = Counted(__libc_memalign(alignment, size));
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) {
  Freed(memory);
  __libc_free(memory);
}
}

#else

void* operator new(std::size_t size) {
  Count();
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) std::abort();
  return memory;
}
void* operator new[](std::size_t size) { return operator new(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

#endif

namespace styled::support {

CountNew::CountNew() {
  ::calls = 0;
#if COUNT_MALLOC
  live = peak = 0;
#endif
  counting = true;
}
CountNew::~CountNew() { counting = false; }
int CountNew::calls() const { return ::calls; }
std::size_t CountNew::peak_bytes() const {
#if COUNT_MALLOC
  return static_cast<std::size_t>(peak.load());
#else
  return 0;
#endif
}
bool CountNew::CountsMalloc() {
#if COUNT_MALLOC
  return true;
#else
  return false;
#endif
}

}  // namespace styled::support

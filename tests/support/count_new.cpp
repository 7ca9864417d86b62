#include "tests/support/count_new.h"

#include <atomic>
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

// glibc's names for the functions replaced below; operator new also ends there.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
// NOLINTEND(bugprone-reserved-identifier)
void* malloc(std::size_t size) {
  Count();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  Count();
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  Count();
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  Count();
  return __libc_memalign(alignment, size);
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
  counting = true;
}
CountNew::~CountNew() { counting = false; }
int CountNew::calls() const { return ::calls; }
bool CountNew::CountsMalloc() {
#if COUNT_MALLOC
  return true;
#else
  return false;
#endif
}

}  // namespace styled::support

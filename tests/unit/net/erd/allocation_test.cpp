// Start and Step allocate nothing. This binary's malloc and operator new count their calls.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/unit/net/erd/random_weights.h"

// Sanitizers replace malloc themselves; with them only operator new is counted.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COUNT_MALLOC 1
#endif

namespace {

std::atomic<bool> counting{false};
std::atomic<int> allocations{0};

void Count() {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1);
}

void* Allocate(std::size_t size) {
  Count();
  void* memory = std::malloc(size);
  if (memory == nullptr) std::abort();
  return memory;
}
void* Allocate(std::size_t size, std::align_val_t alignment) {
  Count();
  void* memory = nullptr;
  if (posix_memalign(&memory, static_cast<std::size_t>(alignment), size) != 0) std::abort();
  return memory;
}

}  // namespace

#if COUNT_MALLOC
// glibc's own names for the functions replaced below.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
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
}
#endif

void* operator new(std::size_t size) { return Allocate(size); }
void* operator new[](std::size_t size) { return Allocate(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return Allocate(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return Allocate(size, alignment);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace styled::erd {
namespace {

template <typename Work>
int AllocationsIn(Work work) {
  allocations = 0;
  counting = true;
  work();
  counting = false;
  return allocations;
}

void* volatile sink = nullptr;  // keeps an allocation from being optimized away

TEST(Allocations, ArePerceived) {
  EXPECT_GE(AllocationsIn([] {
              int* one = new int(1);
              sink = one;
              delete one;
            }),
            1);
  EXPECT_GE(AllocationsIn([] {
              const Eigen::MatrixXf matrix = Eigen::MatrixXf::Random(64, 64);
              sink = const_cast<float*>(matrix.data());
            }),
            1);
#if COUNT_MALLOC
  EXPECT_GE(AllocationsIn([] {
              sink = std::malloc(7);
              std::free(sink);
            }),
            1);
#endif
}

TEST(Allocations, NoneInStartAndStep) {
  const auto network = RandomNetwork(8, 1);
  const std::vector<net::StyleWeight> mix{{1, 0.3F}, {2, 0.3F}, {3, 0.2F}, {4, 0.1F}};
  const std::vector<net::StyleWeight> other{{5, 1.0F}, {2, 0.0F}};
  Features features;
  features.fill(0.1F);
  State state;
  net::Prediction out;
  EXPECT_EQ(AllocationsIn([&] {
              network->Start(state);
              for (int frame = 0; frame < 50; ++frame) {
                network->Step(features, 0, {}, state, out);
                network->Step(features, 0, mix, state, out);
                network->Step(features, 6, other, state, out);
              }
            }),
            0);
}

}  // namespace
}  // namespace styled::erd

// Preloaded into the release `styled` by hot_section_test: defines the marks that the daemon looks
// for (daemon/runtime/realtime.h) and counts, on the thread between them, every call of an
// allocation, locking, writing or throwing entry point. At exit it writes the counts and the first
// callers to $STYLED_HOOK_REPORT. $STYLED_HOOK_PROVOKE=malloc|free|lock|write|throw does that very
// thing once in each section: the negative control.
#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t);            // NOLINT: glibc's own names, so that dlsym is not needed
void* __libc_calloc(size_t, size_t);    // NOLINT
void* __libc_realloc(void*, size_t);    // NOLINT
void* __libc_memalign(size_t, size_t);  // NOLINT
void __libc_free(void*);                // NOLINT
}

namespace {

enum Kind { kMalloc, kFree, kLock, kWrite, kThrow, kKinds };
constexpr const char* kNames[kKinds] = {"malloc", "free", "lock", "write", "throw"};

__attribute__((tls_model("initial-exec"))) thread_local bool inside = false;
// Sections may be nested: a part that the pipeline thread shares with helpers is within its own.
__attribute__((tls_model("initial-exec"))) thread_local int depth = 0;
std::atomic<unsigned long> sections{0};
std::atomic<unsigned long> hits[kKinds];
constexpr int kCallers = 16;
std::atomic<int> caller_count{0};
void* callers[kCallers];

void Count(Kind kind, void* caller) {
  if (!inside) return;
  hits[kind].fetch_add(1);
  const int slot = caller_count.fetch_add(1);
  if (slot < kCallers) callers[slot] = caller;
}

int Provocation() {
  static const int kind = [] {
    const char* const text = std::getenv("STYLED_HOOK_PROVOKE");
    for (int i = 0; text != nullptr && i < kKinds; ++i) {
      if (std::strcmp(text, kNames[i]) == 0) return i;
    }
    return -1;
  }();
  return kind;
}

pthread_mutex_t provoked_mutex = PTHREAD_MUTEX_INITIALIZER;
void* volatile provoked = nullptr;

void Provoke() {
  switch (Provocation()) {
    case kMalloc:
      provoked = std::malloc(16);
      inside = false;
      std::free(provoked);
      inside = true;
      break;
    case kFree:
      inside = false;
      provoked = std::malloc(16);
      inside = true;
      std::free(provoked);
      break;
    case kLock:
      pthread_mutex_lock(&provoked_mutex);
      pthread_mutex_unlock(&provoked_mutex);
      break;
    case kWrite:
      if (write(STDERR_FILENO, "", 0) != 0) std::abort();
      break;
    case kThrow:
      try {
        throw 1;
      } catch (int) {
      }
      break;
    default:
      break;
  }
}

void Report() {
  inside = false;
  const char* const file = std::getenv("STYLED_HOOK_REPORT");
  std::FILE* const out = file == nullptr ? nullptr : std::fopen(file, "w");
  if (out == nullptr) return;
  std::fprintf(out, "sections %lu\n", sections.load());
  for (int i = 0; i < kKinds; ++i) std::fprintf(out, "%s %lu\n", kNames[i], hits[i].load());
  for (int i = 0; i < kCallers && i < caller_count.load(); ++i) {
    Dl_info info{};
    dladdr(callers[i], &info);
    std::fprintf(out, "caller %s %s +0x%lx\n", info.dli_fname != nullptr ? info.dli_fname : "?",
                 info.dli_sname != nullptr ? info.dli_sname : "?",
                 static_cast<unsigned long>(static_cast<char*>(callers[i]) -
                                            static_cast<char*>(info.dli_fbase)));
  }
  std::fclose(out);
}

__attribute__((destructor)) void AtExit() { Report(); }

template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

__attribute__((visibility("default"))) void styled_realtime_enter() {
  inside = true;
  ++depth;
  sections.fetch_add(1);
  Provoke();
}
__attribute__((visibility("default"))) void styled_realtime_exit() { inside = --depth > 0; }

void* malloc(size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  return __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) noexcept {
  Count(kMalloc, __builtin_return_address(0));
  *out = __libc_memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}
void free(void* memory) noexcept {
  if (memory != nullptr) Count(kFree, __builtin_return_address(0));
  __libc_free(memory);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto next = Next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  Count(kLock, __builtin_return_address(0));
  return next(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  static const auto next = Next<int (*)(pthread_mutex_t*)>("pthread_mutex_trylock");
  Count(kLock, __builtin_return_address(0));
  return next(mutex);
}

ssize_t write(int fd, const void* data, size_t size) {
  static const auto next = Next<ssize_t (*)(int, const void*, size_t)>("write");
  Count(kWrite, __builtin_return_address(0));
  return next(fd, data, size);
}

[[noreturn]] void __cxa_throw(void* object, void* type, void (*destroy)(void*)) {  // NOLINT
  using Throw = void (*)(void*, void*, void (*)(void*));
  static const auto next = Next<Throw>("__cxa_throw");
  Count(kThrow, __builtin_return_address(0));
  next(object, type, destroy);
  __builtin_unreachable();
}

}  // extern "C"

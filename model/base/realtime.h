#pragma once

// Marks a function of the hot path: it must not allocate, lock, block, log or throw. Clang 20 and
// later check that, through every call (tests/realtime/effects.py); tests/realtime counts
// allocations and locks of the running daemon, whatever the compiler. Before the declaration, and
// again before a template's definition.
#if defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
// GNU's spelling: it applies to the function's type from in front of the declaration.
#define STYLED_REALTIME __attribute__((nonblocking))
#endif
#endif
#ifndef STYLED_REALTIME
#define STYLED_REALTIME
#endif

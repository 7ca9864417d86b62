#pragma once

// Marks a function of the hot path: it must not allocate, lock, block, log or throw. Clang 20 and
// later check it (function effects); elsewhere tests/realtime does, on the release binary.
#if defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define STYLED_REALTIME [[clang::nonblocking]]
#endif
#endif
#ifndef STYLED_REALTIME
#define STYLED_REALTIME
#endif

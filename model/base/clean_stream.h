#pragma once

#include <array>
#include <cstdio>
#include <ostream>
#include <streambuf>
#include <string>

#include "model/base/text.h"

namespace styled {

// A stream for a terminal, safe for text from a daemon or from another program at its address. Each
// line passes through Printable on its way to `target`, so that no text can move the cursor, change
// colours or the direction of writing. A line is written when it ends, and at each flush. JSON
// remains valid: it has no control character below U+0020, and others become \u escapes. One
// thread.
class CleanStream final : public std::ostream {
 public:
  explicit CleanStream(std::ostream& target) : std::ostream(&buffer_), buffer_(target) {}
  ~CleanStream() override { flush(); }

 private:
  class Buffer final : public std::streambuf {
   public:
    explicit Buffer(std::ostream& target) : target_(target) {}

   protected:
    int overflow(int c) override {
      if (c == traits_type::eof()) return traits_type::not_eof(c);
      if (c == '\n') return WriteLine("\n") ? c : traits_type::eof();
      line_ += static_cast<char>(c);
      return c;
    }
    int sync() override {
      const bool written = WriteLine("");
      target_.flush();
      return written && target_ ? 0 : -1;
    }

   private:
    bool WriteLine(const char* end) {
      for (std::size_t at = 0; at < line_.size(); ++at) {
        // U+007F, and U+0080 to U+009F, which are two bytes.
        const auto first = static_cast<unsigned char>(line_[at]);
        const auto second = static_cast<unsigned char>(at + 1 < line_.size() ? line_[at + 1] : 0);
        const bool wide = first == 0xC2 && second >= 0x80 && second < 0xA0;
        if (first != 0x7F && !wide) continue;
        std::array<char, 8> escaped;
        std::snprintf(escaped.data(), escaped.size(), "\\u%04x", wide ? second : first);
        line_.replace(at, wide ? 2 : 1, escaped.data());
      }
      target_ << Printable(line_, line_.size() * 8 + 8) << end;
      line_.clear();
      return static_cast<bool>(target_);
    }

    std::ostream& target_;
    std::string line_;
  };
  Buffer buffer_;
};

}  // namespace styled

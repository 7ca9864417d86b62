#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>

namespace styled {

// The outcome of a step off the hot path: ok, or a message that names the place (a file, a key, a
// command), the value found and what was expected. Errors in frames are an enum instead.
// Allocates.
class [[nodiscard]] Status {
 public:
  static Status Ok() { return Status(); }
  // `code`: for a caller that answers with one, as a control request's reply; 0: none.
  static Status Error(int code, std::string message) {
    Status status = Error(std::move(message));
    status.code_ = code;
    return status;
  }
  static Status Error(std::string message) {
    Status status;
    status.message_ = message.empty() ? "unknown error" : std::move(message);
    return status;
  }

  bool ok() const { return message_.empty(); }
  const std::string& message() const { return message_; }
  int code() const { return code_; }

 private:
  std::string message_;
  int code_ = 0;
};

// A value, or the Status that explains why there is none. Call `value()` only if `ok()`.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}                                  // NOLINT
  Result(Status status) : status_(std::move(status)) { assert(!status_.ok()); }  // NOLINT

  bool ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }
  T& value() { return *value_; }
  const T& value() const { return *value_; }

 private:
  std::optional<T> value_;
  Status status_ = Status::Ok();
};

}  // namespace styled

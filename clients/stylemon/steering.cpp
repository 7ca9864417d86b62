#include "clients/stylemon/steering.h"

#include <array>
#include <cstdio>
#include <utility>

namespace styled::stylemon {
namespace {

constexpr std::size_t kMaxWaiting = 16;  // so that a held key does not fill the queue for minutes

}  // namespace

Steering::Steering(std::unique_ptr<client::Control> control)
    : control_(std::move(control)), thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

Steering::~Steering() = default;

Result<std::unique_ptr<Steering>> Steering::Start(const std::string& endpoint,
                                                  const std::optional<client::Curve>& curve) {
  auto control = client::Control::Connect(
      {.endpoint = endpoint, .timeout = std::chrono::milliseconds(700), .curve = curve});
  if (!control.ok()) return control.status();
  return std::unique_ptr<Steering>(new Steering(std::move(control.value())));
}

void Steering::Loop(const std::stop_token& stop) {
  for (;;) {
    Command command;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return !commands_.empty(); })) return;
      if (stop.stop_requested()) return;
      command = std::move(commands_.front());
      commands_.pop_front();
    }
    command(*control_);
  }
}

void Steering::Push(Command command) {
  {
    const std::scoped_lock lock(mutex_);
    if (commands_.size() >= kMaxWaiting) commands_.pop_front();
    commands_.push_back(std::move(command));
  }
  wake_.notify_one();
}

void Steering::FetchStyles() {
  Push([this](client::Control& control) {
    v1::ListReply list;
    if (!control.List(&list).ok()) return;
    std::vector<std::string> styles;
    for (const auto& style : list.styles()) {
      if (!style.neutral()) styles.push_back(style.name());
    }
    const std::scoped_lock lock(mutex_);
    state_.styles = std::move(styles);
  });
}

void Steering::Change(const std::string& performer, const v1::Look& change,
                      const std::string& what) {
  Push([this, performer, change, what](client::Control& control) {
    client::Applied applied;
    const client::CallStatus status = control.Set(performer, change, &applied);
    std::string message = status.ok() ? what : status.reason();
    if (!applied.empty()) message += " from #" + std::to_string(applied[0].first_sequence());
    const std::scoped_lock lock(mutex_);
    state_.message = std::move(message);
    state_.bad = !status.ok();
  });
}

void Steering::SetStyle(const std::string& performer, const std::string& style) {
  v1::Look change;
  change.add_mix()->set_style(style);
  change.mutable_mix(0)->set_weight(1.0F);
  Change(performer, change, style);
}

void Steering::SetStrength(const std::string& performer, float strength) {
  v1::Look change;
  change.set_strength(strength);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "strength %.1f", strength);
  Change(performer, change, text.data());
}

void Steering::Clear(const std::string& performer) {
  v1::Look change;
  change.set_clear(true);
  Change(performer, change, "bypass");
}

Steering::State Steering::state() {
  const std::scoped_lock lock(mutex_);
  return state_;
}

}  // namespace styled::stylemon

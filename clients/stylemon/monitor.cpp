#include "clients/stylemon/monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "clients/cpp/control.h"
#include "clients/cpp/key_options.h"
#include "clients/cpp/reach.h"
#include "proto/styled/look.h"

namespace styled::stylemon {
namespace {

using Clock = std::chrono::steady_clock;
using client::Update;
using std::chrono::milliseconds;

constexpr float kYawShare = 0.08F;   // fraction of the way to the current facing, per frame
constexpr float kFloorBand = 0.15F;  // fraction of the height: a floor this near to 0 is drawn at 0
constexpr double kListAfter_s = 3.0;  // older statistics no longer determine the list of performers
constexpr double kStylesEvery_s = 2.0;  // interval of requests for the style list until it is known
constexpr float kPi = 3.14159265F;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

std::int64_t WallNow_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string SetText(const v1::PerformerStats& stats) {
  std::string out;
  std::array<char, 16> number{};
  const v1::Look& look = stats.look();
  for (const auto& entry : look.mix()) {
    std::snprintf(number.data(), number.size(), " %.2f", entry.weight());
    out += (out.empty() ? "" : " + ") + entry.style() + number.data();
  }
  if (out.empty()) out = "bypass";
  if (!look.mix().empty() && std::abs(look.strength() - 1.0F) > 0.001F) {
    std::snprintf(number.data(), number.size(), " x %.2f", look.strength());
    out += number.data();
  }
  const body::Parts parts = PartsOf(look);
  if (parts != 0 && parts != body::kAllParts) out += " only " + body::PartsText(parts);
  if (const std::string layers = client::LayersText(stats); !layers.empty()) out += "  " + layers;
  return stats.pinned() ? "pinned " + out : out;
}

}  // namespace

struct Monitor::Impl {
  MonitorOptions options;
  std::unique_ptr<client::Subscriber> directory;  // bodies of all performers, statistics
  std::unique_ptr<client::Subscriber> frames;     // one performer's streams
  std::unique_ptr<Steering> steering;
  std::unique_ptr<client::Lookout> lookout;
  View view;
  Meter meter;
  Update update;
  v1::Stats stats;
  Clock::time_point stats_at{}, link_at = Clock::now(), input_at{}, styled_at{}, styles_at{};
  std::string selected;
  bool connected = false, yaw_known = false;
  float strength = 1.0F;            // of the selected performer, as last received or set by a key
  Clock::time_point strength_at{};  // when a key set it
  float extent = 0;                 // largest height seen, if the bones do not determine it
  float lowest = 0;                 // smoothed height of the lowest joint
  Eigen::Vector3f last_hips = Eigen::Vector3f::Zero();
  std::map<const v1::Body*, std::shared_ptr<const Anatomy>> anatomies;
  // Keeps the addresses used as keys above alive.
  std::vector<std::shared_ptr<const v1::Body>> held;
  std::uint64_t styled_frames = 0;

  void Select(const std::string& performer);
  void Apply(Update& update);
  void ApplyFrame(Update& update);
  void Follow(const Figure& figure);
  std::shared_ptr<const Anatomy> AnatomyOf(const std::shared_ptr<const v1::Body>& body);
  void RefreshLink();
  void RefreshPerformers();
  const v1::PerformerStats* StatsOf(const std::string& performer) const;
};

Monitor::Monitor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Monitor::~Monitor() = default;

Result<std::unique_ptr<Monitor>> Monitor::Start(const MonitorOptions& options) {
  client::SubscriberOptions listen;
  listen.endpoints = {options.publisher};
  listen.streams.clear();
  listen.statistics = true;
  listen.curve = options.curve;
  auto directory = client::Subscriber::Connect(listen);
  if (!directory.ok()) return directory.status();
  auto steering = Steering::Start(options.control, options.curve);
  if (!steering.ok()) return steering.status();
  if (!options.performer.empty() && !client::IsPerformerId(options.performer)) {
    return Status::Error("performer '" + options.performer + "' is not SOURCE.NAME");
  }
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->directory = std::move(directory.value());
  impl->steering = std::move(steering.value());
  impl->lookout =
      std::make_unique<client::Lookout>(options.publisher.substr(0, options.publisher.find(',')),
                                        client::Peer::kPublisher, options.curve);
  impl->view.publisher = options.publisher;
  impl->view.control = options.control;
  impl->view.side = options.side;
  if (!options.performer.empty()) impl->Select(options.performer);
  return std::unique_ptr<Monitor>(new Monitor(std::move(impl)));
}

void Monitor::Impl::Select(const std::string& performer) {
  client::SubscriberOptions listen;
  listen.endpoints = {options.publisher};
  listen.performer = performer;
  listen.curve = options.curve;
  listen.streams = {client::Stream::kStyledRig, client::Stream::kSource};
  auto result = client::Subscriber::Connect(listen);
  if (!result.ok()) return;  // the endpoint was valid before: out of sockets
  frames = std::move(result.value());
  selected = performer;
  view.input = Figure();
  view.styled = Figure();
  view.travel = 0;
  meter = Meter();
  yaw_known = false;
  extent = 0;
  lowest = 0;
  anatomies.clear();
  held.clear();
  strength = 1.0F;
  strength_at = {};
}

std::shared_ptr<const Anatomy> Monitor::Impl::AnatomyOf(
    const std::shared_ptr<const v1::Body>& body) {
  if (anatomies.size() > 16) {
    anatomies.clear();
    held.clear();
  }
  auto [entry, is_new] = anatomies.try_emplace(body.get());
  if (is_new) {
    entry->second = std::make_shared<const Anatomy>(Analyse(*body));
    held.push_back(body);
  }
  return entry->second;
}

void Monitor::Impl::Apply(Update& update) {
  switch (update.kind) {
    case Update::Kind::kStatistics:
      stats.Swap(&update.statistics);
      stats_at = Clock::now();
      break;
    case Update::Kind::kFrame:
      ApplyFrame(update);
      break;
    case Update::Kind::kBody:
      break;  // the subscriber keeps bodies
  }
}

void Monitor::Impl::ApplyFrame(Update& update) {
  const auto now = Clock::now();
  const v1::Frame& frame = update.frame;
  const bool styled = update.stream == client::Stream::kStyledRig;
  if (styled) {
    ++styled_frames;
    const auto now_ns =
        std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()).count();
    meter.Add(now_ns, static_cast<std::int64_t>(frame.publish_time_ns() - frame.receive_time_ns()),
              WallNow_ns() - static_cast<std::int64_t>(frame.wall_time_ns()), update.missed);
  }
  if (view.paused || update.body == nullptr) return;
  Figure& figure = styled ? view.styled : view.input;
  if (WorldTransforms(*update.body, frame, figure.joints) != client::FrameError::kNone) return;
  figure.anatomy = AnatomyOf(update.body);
  figure.here = true;
  figure.frame.Swap(&update.frame);
  (styled ? styled_at : input_at) = now;
  if (!styled) Follow(figure);
}

// The view follows the input figure, for both pictures: otherwise a style that leans would not
// appear to lean.
void Monitor::Impl::Follow(const Figure& figure) {
  float yaw = 0;
  if (Facing(*figure.anatomy, figure.joints, yaw)) {
    const float turn = std::remainder(yaw - view.yaw_rad, 2 * kPi);
    view.yaw_rad += yaw_known ? kYawShare * turn : turn;
  }
  const Eigen::Vector3f hips = figure.joints[0].position;
  if (yaw_known) view.travel += PictureX(view.side, view.yaw_rad).dot(hips - last_hips);
  last_hips = hips;
  float top = hips.y();
  for (const client::Transform& joint : figure.joints) top = std::max(top, joint.position.y());
  const float low = Lowest(figure.joints);
  extent = std::max(extent, top - low);
  view.height = PictureHeight(*figure.anatomy, extent);
  // A floor near 0 is drawn at 0; otherwise at the smoothed height of the feet.
  lowest = yaw_known ? lowest + (low < lowest ? 0.2F : 0.01F) * (low - lowest) : low;
  const float body_height = figure.anatomy->height > 0 ? figure.anatomy->height : view.height;
  view.floor = std::abs(lowest) < kFloorBand * body_height ? 0 : lowest;
  yaw_known = true;
}

const v1::PerformerStats* Monitor::Impl::StatsOf(const std::string& performer) const {
  for (const auto& entry : stats.performers()) {
    if (entry.performer() == performer) return &entry;
  }
  return nullptr;
}

void Monitor::Impl::RefreshLink() {
  const bool now = directory->connected() > 0;
  if (now != connected) {
    connected = now;
    view.link = now ? Link::kThere : Link::kLost;
    link_at = Clock::now();
    styles_at = {};
  }
  view.link_s = Seconds(Clock::now() - link_at);
  view.obstacle.clear();
  if (now) {
    lookout->Rest();
  } else {
    const client::Reach& reach = lookout->Look();
    view.obstacle = reach.text;
    const std::string advice = client::Advice(reach.obstacle, client::Peer::kPublisher);
    if (!advice.empty()) view.obstacle += "; " + advice;
  }
  if (connected && (styles_at == Clock::time_point() ||
                    (view.styles.empty() && Seconds(Clock::now() - styles_at) > kStylesEvery_s))) {
    styles_at = Clock::now();
    steering->FetchStyles();
  }
}

void Monitor::Impl::RefreshPerformers() {
  view.performers.clear();
  if (connected && Seconds(Clock::now() - stats_at) < kListAfter_s) {
    for (const auto& entry : stats.performers()) {
      view.performers.push_back({entry.performer(), entry.live(), SetText(entry)});
    }
  } else {  // without statistics, or with the daemon down: the performers seen so far
    for (const std::string& name : directory->performers()) {
      view.performers.push_back({name, connected, ""});
    }
  }
  const auto find = [this](const std::string& name) {
    return std::find_if(view.performers.begin(), view.performers.end(),
                        [&name](const PerformerLine& line) { return line.performer == name; });
  };
  if (selected.empty() && !view.performers.empty()) {
    auto first = std::find_if(view.performers.begin(), view.performers.end(),
                              [](const PerformerLine& line) { return line.live; });
    Select(first == view.performers.end() ? view.performers[0].performer : first->performer);
  }
  if (!selected.empty() && find(selected) == view.performers.end()) {
    if (view.styled.here || !options.performer.empty() || !view.performers.empty()) {
      view.performers.push_back({selected, false, ""});
    }
  }
  std::sort(view.performers.begin(), view.performers.end(),
            [](const auto& a, const auto& b) { return a.performer < b.performer; });
  const auto mine = find(selected);
  view.selected =
      mine == view.performers.end() ? -1 : static_cast<int>(mine - view.performers.begin());
  const v1::PerformerStats* entry = StatsOf(selected);
  view.set = entry == nullptr ? "" : SetText(*entry);
  if (entry != nullptr && Seconds(Clock::now() - strength_at) > 2.0)
    strength = entry->look().strength();
}

void Monitor::Listen(milliseconds duration) {
  Impl& impl = *impl_;
  const auto end = Clock::now() + duration;
  do {
    while (impl.directory->Receive(milliseconds(0), impl.update)) impl.Apply(impl.update);
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    const milliseconds wait = std::clamp(left, milliseconds(0), milliseconds(50));
    client::Subscriber& source = impl.frames ? *impl.frames : *impl.directory;
    if (source.Receive(wait, impl.update)) impl.Apply(impl.update);
  } while (Clock::now() < end);
}

const View& Monitor::view() {
  Impl& impl = *impl_;
  impl.RefreshLink();
  impl.RefreshPerformers();
  const auto now = Clock::now();
  View& view = impl.view;
  view.input.age_s = Seconds(now - impl.input_at);
  view.styled.age_s = view.paused ? 0 : Seconds(now - impl.styled_at);
  view.reading = impl.meter.Read(
      std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()).count());
  const Steering::State state = impl.steering->state();
  view.styles = state.styles;
  if (view.first_style >= view.styles.size()) view.first_style = 0;
  view.message = state.message;
  view.message_bad = state.bad;
  return view;
}

void Monitor::Press(Key key) {
  Impl& impl = *impl_;
  View& view = impl.view;
  const int count = static_cast<int>(view.performers.size());
  const auto select = [&](int step) {
    if (count == 0) return;
    const int next = (view.selected + step + count) % count;
    impl.Select(view.performers[static_cast<std::size_t>(next)].performer);
  };
  const auto stronger = [&](float step) {
    if (impl.selected.empty()) return;
    impl.strength = std::clamp(std::round((impl.strength + step) * 10) / 10, 0.0F, 1.5F);
    impl.strength_at = Clock::now();
    impl.steering->SetStrength(impl.selected, impl.strength);
  };
  switch (key) {
    case Key::kNextPerformer:
      return select(1);
    case Key::kPreviousPerformer:
      return select(-1);
    case Key::kSide:
      view.side = view.side == Side::kSide ? Side::kFront : Side::kSide;
      view.travel = 0;
      return;
    case Key::kPause:
      view.paused = !view.paused;
      return;
    case Key::kClear:
      if (!impl.selected.empty()) impl.steering->Clear(impl.selected);
      return;
    case Key::kMoreStyles:
      view.first_style += kStyleKeys;
      if (view.first_style >= view.styles.size()) view.first_style = 0;
      return;
    case Key::kStronger:
      return stronger(0.1F);
    case Key::kWeaker:
      return stronger(-0.1F);
  }
}

void Monitor::PressStyle(int number) {
  const std::vector<std::string> styles = impl_->steering->state().styles;
  const std::size_t style = impl_->view.first_style + static_cast<std::size_t>(number - 1);
  if (impl_->selected.empty() || number < 1 || style >= styles.size()) return;
  impl_->steering->SetStyle(impl_->selected, styles[style]);
}

std::uint64_t Monitor::frames() const { return impl_->styled_frames; }

}  // namespace styled::stylemon

#include <span>
#include <utility>
#include <vector>

#include "model/stylist/stylist.h"
#include "model/stylist/stylist_impl.h"

namespace styled::stylist {
namespace {

void PrefetchObject(std::span<const std::byte> bytes) noexcept {
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < bytes.size(); at += kLine) __builtin_prefetch(&bytes[at]);
}

}  // namespace

struct Rehearsal::Scratch {
  Stylist stylist;
  Output out;
  std::int64_t time_ns = 0;
};

Rehearsal::Rehearsal(std::shared_ptr<const net::Stylizer> network,
                     const std::shared_ptr<const rig::Binding>& binding, const Options& options)
    : scratch_(new Scratch{Stylist(std::move(network), binding, options),
                           Output(binding->skeleton())}) {}
Rehearsal::~Rehearsal() = default;
Rehearsal::Rehearsal(Rehearsal&&) noexcept = default;
Rehearsal& Rehearsal::operator=(Rehearsal&&) noexcept = default;

void Rehearsal::Adopt(std::shared_ptr<const net::Stylizer> network) noexcept {
  scratch_->stylist.Adopt(std::move(network));
}

std::shared_ptr<Rehearsal> Rehearsal::Shared(const std::shared_ptr<const net::Stylizer>& network,
                                             const std::shared_ptr<const rig::Binding>& binding,
                                             const Options& options) {
  thread_local std::vector<std::weak_ptr<Rehearsal>> rehearsals;
  std::erase_if(rehearsals, [](const auto& kept) { return kept.expired(); });
  const auto fits = [&](const Rehearsal& kept) {
    const Stylist::Impl& s = *kept.scratch_->stylist.impl_;
    return s.predictor.network() == network.get() &&
           s.binding->skeleton().joint_count() == binding->skeleton().joint_count();
  };
  for (const auto& kept : rehearsals) {
    if (auto shared = kept.lock(); fits(*shared)) return shared;
  }
  auto made = std::make_shared<Rehearsal>(network, binding, options);
  rehearsals.push_back(made);
  return made;
}

// Runs the last pose through the scratch stylist, at the usual frame interval.
void Rehearsal::Prewarm(const Stylist& stylist) noexcept {
  const Stylist::Impl& s = *stylist.impl_;
  PrefetchObject(std::as_bytes(std::span(&s, 1)));
  s.predictor.Prefetch();
  Scratch& r = *scratch_;
  constexpr std::int64_t kUsual_ns = 1'000'000'000 / 120;
  const bool usual = s.dt_s > 0 && s.dt_s <= s.options.gap_reset_s;
  r.time_ns += usual ? static_cast<std::int64_t>(s.dt_s * 1e9) : kUsual_ns;
  r.stylist.impl_->mixer = s.mixer;
  r.stylist.Process(r.time_ns, s.input_guard.clean(), r.out);
}

}  // namespace styled::stylist

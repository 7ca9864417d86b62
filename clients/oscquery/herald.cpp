#include "clients/oscquery/herald.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <utility>

#include "clients/cpp/key_options.h"
#include "clients/oscquery/tree.h"

namespace styled::oscquery {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick(100);
constexpr std::chrono::seconds kAskAgain(1), kPatience(3);

std::string ListenText(const Source& source) {
  const bool v6 = source.address.find(':') != std::string::npos;
  return (v6 ? "[" + source.address + "]" : source.address) + ":" + std::to_string(source.port);
}

}  // namespace

Herald::Herald(boost::asio::io_context& io, const Options& options, std::ostream& out,
               std::ostream& err)
    : io_(io),
      options_(options),
      out_(out),
      err_(err),
      timer_(io),
      answered_(Clock::now()),
      asked_(Clock::now() - kAskAgain) {}

Result<std::unique_ptr<Herald>> Herald::Start(boost::asio::io_context& io, const Options& options,
                                              std::ostream& out, std::ostream& err) {
  auto asker = client::Asker::Start(options.control, options.curve);
  if (!asker.ok()) return Status::Error("--control: " + asker.status().message());
  std::unique_ptr<Herald> herald(new Herald(io, options, out, err));
  herald->asker_ = std::move(asker.value());
  herald->Tick();
  return herald;
}

void Herald::Tick() {
  if (!asking_ && Clock::now() - asked_ >= kAskAgain) Ask();
  ShowState();
  timer_.expires_after(kTick);
  timer_.async_wait([this](const boost::system::error_code& aborted) {
    if (!aborted) Tick();
  });
}

void Herald::Ask() {
  asking_ = true;
  asked_ = Clock::now();
  v1::Request request;
  request.mutable_status();
  const bool queued = asker_->Ask(request, [this](client::CallStatus status, v1::Reply reply) {
    boost::asio::post(io_, [this, status = std::move(status), reply = std::move(reply)] {
      Receive(status, reply);
    });
  });
  if (!queued) asking_ = false;
}

void Herald::Receive(const client::CallStatus& status, const v1::Reply& reply) {
  asking_ = false;
  if (status.ok()) {
    answered_ = Clock::now();
    daemon_trouble_.clear();
    return Serve(MakePlan(reply.status()));
  }
  const std::string advice = client::Advice(status.obstacle(), client::Peer::kControl);
  const std::string text =
      options_.control + ": " + status.reason() + (advice.empty() ? "" : "; " + advice);
  if (daemon_trouble_ != text) err_ << "styleoscquery: " << text << std::endl;
  daemon_trouble_ = text;
  const bool gone = status.obstacle() == client::Obstacle::kNobody;
  if (gone || Clock::now() - answered_ >= kPatience) Serve({});
}

void Herald::Notice(const std::string& text) {
  if (notices_.insert(text).second) err_ << "styleoscquery: " << text << std::endl;
}

// Sources may share a name: styled-stage, styled-stage-2.
std::string Herald::FreeName(const std::string& source) const {
  const std::string first = options_.name + "-" + source;
  std::string name = first;
  const auto has_name = [&name](const Service& service) { return service.name == name; };
  for (int i = 2; std::any_of(services_.begin(), services_.end(), has_name); ++i) {
    name = first + "-" + std::to_string(i);
  }
  return name;
}

void Herald::Serve(const Plan& plan) {
  for (const std::string& notice : plan.notices) Notice(notice);
  const auto& sources = plan.sources;
  // First the old ones leave, whose names and ports the new ones may have.
  std::erase_if(services_, [&](const Service& service) {
    if (std::find(sources.begin(), sources.end(), service.source) != sources.end()) return false;
    out_ << "styleoscquery: " << service.name << " is withdrawn" << std::endl;
    return true;
  });
  for (const Source& source : sources) {
    const bool known = std::any_of(services_.begin(), services_.end(),
                                   [&](const Service& s) { return s.source == source; });
    if (known) continue;
    const std::string name = FreeName(source.name);
    const std::string text = source.name + " of styled, which takes " + source.type;
    auto server = Server::Start(io_, source.address,
                                {name, TreeOf(MethodsOf(source.type), text), source.port});
    if (!server.ok()) {
      Notice(source.name + ": " + server.status().message());
      continue;
    }
    services_.push_back({source, name, "", std::move(server.value())});
  }
  std::vector<Announcement> announcements;
  for (const Service& s : services_) {
    announcements.push_back({s.name, s.server->port(), s.source.port, s.source.places});
  }
  advertiser_.Set(std::move(announcements));
}

// Prints the names under which the sources can be found, and what prevents that.
void Herald::ShowState() {
  const Advertiser::State state = advertiser_.state();
  if (state.trouble != std::exchange(trouble_, state.trouble) && !trouble_.empty()) {
    err_ << "styleoscquery: " << trouble_ << std::endl;
  }
  for (Service& service : services_) {
    const auto name = state.names.find(service.name);
    const std::string now = name == state.names.end() ? "" : name->second;
    if (now == std::exchange(service.shown, now) || now.empty()) continue;
    service.server->Rename(now);
    out_ << "styleoscquery: " << service.source.name << " (" << service.source.type << ", "
         << ListenText(service.source) << ") can be found as " << now << ", HTTP port "
         << service.server->port() << std::endl;
  }
}

}  // namespace styled::oscquery

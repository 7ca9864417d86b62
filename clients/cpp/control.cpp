#include "clients/cpp/control.h"

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>
#include <zmq.hpp>

namespace styled::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::int64_t kMaxReplyBytes = 16 << 20;
constexpr milliseconds kGlance(100);  // interval of the checks whether a call should end early

// Reads the last part of a waiting message: the payload, with or without the empty delimiter before
// it.
bool ReadLastPart(zmq::socket_t& socket, zmq::message_t& part) {
  if (!socket.recv(part, zmq::recv_flags::dontwait)) return false;
  while (socket.get(zmq::sockopt::rcvmore)) {
    if (!socket.recv(part, zmq::recv_flags::none)) return false;
  }
  return true;
}

}  // namespace

struct Control::Impl {
  ControlOptions options;              // `endpoint`: the one in use
  std::vector<std::string> endpoints;  // tried first
  zmq::context_t context{1};
  zmq::socket_t socket;
  std::uint64_t next_id = 1;

  // A new socket discards replies that were still on their way to the old one.
  void Open() {
    socket = zmq::socket_t(context, zmq::socket_type::dealer);
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::maxmsgsize, kMaxReplyBytes);
    socket.set(zmq::sockopt::reconnect_ivl, 50);
    socket.set(zmq::sockopt::handshake_ivl, 1000);
    if (options.curve) {
      socket.set(zmq::sockopt::curve_serverkey, options.curve->server_key);
      socket.set(zmq::sockopt::curve_publickey, options.curve->public_key);
      socket.set(zmq::sockopt::curve_secretkey, options.curve->secret_key);
    }
    socket.set(zmq::sockopt::ipv6, options.endpoint.find('[') != std::string::npos);
    socket.connect(options.endpoint);
  }

  void UseNext() {
    std::rotate(endpoints.begin(), endpoints.begin() + 1, endpoints.end());
    options.endpoint = endpoints.front();
    Open();
  }

  CallStatus NoAnswer() {
    Open();
    const Reach reach = Examine(options.endpoint, Peer::kControl, options.curve);
    return {CallStatus::Kind::kNoAnswer, v1::CODE_OK,
            "no daemon answers at " + options.endpoint + " within " +
                std::to_string(options.timeout.count()) + " ms: " +
                (reach.text.empty() ? "the daemon is there, but does not reply" : reach.text),
            reach.obstacle};
  }
};

Control::Control(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Control::~Control() = default;

Result<std::unique_ptr<Control>> Control::Connect(const ControlOptions& options) {
  if (options.timeout < milliseconds(1)) {
    return styled::Status::Error("control: timeout is " + std::to_string(options.timeout.count()) +
                                 " ms, expected 1 or more");
  }
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->endpoints = SplitEndpoints(options.endpoint);
  impl->options.endpoint = impl->endpoints.front();
  for (const std::string& endpoint : impl->endpoints) {
    if (const auto checked = CheckEndpoint(endpoint); !checked.ok()) {
      return styled::Status::Error("control: " + checked.message());
    }
  }
  if (options.curve) {
    auto curve = Complete(*options.curve);
    if (!curve.ok()) return styled::Status::Error("control: " + curve.status().message());
    impl->options.curve = std::move(curve.value());
  }
  std::random_device random;  // so that replies to an earlier program do not match
  impl->next_id = (std::uint64_t{random()} << 24U) + 1;
  try {
    impl->Open();
  } catch (const zmq::error_t& error) {
    return styled::Status::Error("control: cannot connect to '" + options.endpoint +
                                 "': " + error.what() + "; expected e.g. " +
                                 std::string(kDefaultControl) + " or ipc://PATH");
  }
  return std::unique_ptr<Control>(new Control(std::move(impl)));
}

CallStatus Control::Call(v1::Request& request, v1::Reply* reply) {
  for (std::size_t tries = impl_->endpoints.size();; --tries) {
    CallStatus status = CallOne(request, reply);
    const bool other =
        status.kind() == CallStatus::Kind::kNoAnswer ||
        (status.kind() == CallStatus::Kind::kRefused && reply->code() == v1::CODE_STANDBY);
    if (!other || tries <= 1 || impl_->options.stop.stop_requested()) return status;
    impl_->UseNext();
  }
}

CallStatus Control::CallOne(v1::Request& request, v1::Reply* reply) {
  Impl& impl = *impl_;
  const auto shown = milliseconds(static_cast<std::int64_t>(1000 * request.like().learn_s()));
  const auto deadline = Clock::now() + impl.options.timeout + shown;
  request.set_id(impl.next_id++);
  try {
    const std::string bytes = request.SerializeAsString();
    // The envelope of a REQ socket, which every ROUTER accepts.
    if (!impl.socket.send(zmq::message_t(), zmq::send_flags::sndmore | zmq::send_flags::dontwait) ||
        !impl.socket.send(zmq::buffer(bytes), zmq::send_flags::dontwait)) {
      return impl.NoAnswer();
    }
    zmq::message_t part;
    for (;;) {
      const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
      if (left <= milliseconds(0)) return impl.NoAnswer();
      if (impl.options.stop.stop_requested()) {
        impl.Open();
        return {CallStatus::Kind::kNoAnswer, v1::CODE_OK, "the program ends"};
      }
      zmq::pollitem_t item{impl.socket.handle(), 0, ZMQ_POLLIN, 0};
      if (zmq::poll(&item, 1, impl.options.stop.stop_possible() ? std::min(left, kGlance) : left) ==
          0) {
        continue;
      }
      if (!ReadLastPart(impl.socket, part)) continue;
      if (!reply->ParseFromArray(part.data(), static_cast<int>(part.size()))) {
        return {CallStatus::Kind::kGarbled, v1::CODE_OK,
                "the program at " + impl.options.endpoint + " is not a styled daemon"};
      }
      if (reply->id() == request.id()) break;
      // A daemon that could not parse the request replies with id 0; any other id belongs to an
      // earlier call.
      if (reply->id() == 0 && reply->code() != v1::CODE_OK) break;
    }
  } catch (const zmq::error_t& error) {
    impl.Open();
    return {CallStatus::Kind::kNoAnswer, v1::CODE_OK,
            std::string("interrupted: ") + error.what()};  // a signal
  }
  if (reply->code() == v1::CODE_OK) return {};
  return {CallStatus::Kind::kRefused, reply->code(),
          reply->reason().empty() ? CodeName(reply->code()) : reply->reason()};
}

// Calls, and moves the part of the reply that `of` gives into `out`, which may be null.
template <typename Out>
CallStatus Control::Ask(v1::Request& request, Out* (v1::Reply::*of)(), Out* out) {
  v1::Reply reply;
  CallStatus status = Call(request, &reply);
  if (status.ok() && out != nullptr) out->Swap((reply.*of)());
  return status;
}

CallStatus Control::Change(v1::Request& request, std::string_view performer, Applied* applied) {
  request.set_performer(performer.data(), performer.size());
  v1::Reply reply;
  CallStatus status = Call(request, &reply);
  if (status.ok() && applied != nullptr) {
    applied->assign(reply.applied().begin(), reply.applied().end());
  }
  return status;
}

CallStatus Control::List(v1::ListReply* out) {
  v1::Request request;
  request.mutable_list();
  return Ask(request, &v1::Reply::mutable_list, out);
}

CallStatus Control::Status(v1::StatusReply* out) {
  v1::Request request;
  request.mutable_status();
  return Ask(request, &v1::Reply::mutable_status, out);
}

CallStatus Control::Set(std::string_view performer, const v1::Look& change, Applied* applied) {
  v1::Request request;
  *request.mutable_set() = change;
  return Change(request, performer, applied);
}

CallStatus Control::SetStyle(std::string_view performer, std::string_view style, float strength,
                             Applied* applied) {
  v1::Look change;
  v1::StyleWeight& weight = *change.add_mix();
  weight.set_style(style.data(), style.size());
  weight.set_weight(1.0F);
  change.set_strength(strength);
  return Set(performer, change, applied);
}

CallStatus Control::Clear(std::string_view performer, Applied* applied) {
  v1::Look change;
  change.set_clear(true);
  return Set(performer, change, applied);
}

CallStatus Control::Preset(std::string_view performer, const v1::Preset& preset, Applied* applied) {
  v1::Request request;
  *request.mutable_preset() = preset;
  return Change(request, performer, applied);
}

CallStatus Control::Pin(std::string_view performer, bool pinned, Applied* applied) {
  v1::Request request;
  request.mutable_pin()->set_pinned(pinned);
  return Change(request, performer, applied);
}

CallStatus Control::Reset(std::string_view performer, Applied* applied) {
  v1::Request request;
  request.mutable_reset();
  return Change(request, performer, applied);
}

CallStatus Control::Calibrate(std::string_view performer, const v1::Calibrate& calibrate,
                              v1::CalibrateReply* out) {
  v1::Request request;
  request.set_performer(performer.data(), performer.size());
  *request.mutable_calibrate() = calibrate;
  return Ask(request, &v1::Reply::mutable_calibrate, out);
}

CallStatus Control::Like(std::string_view performer, const v1::Like& like, v1::LikeReply* out,
                         Applied* applied) {
  v1::Request request;
  request.set_performer(performer.data(), performer.size());
  *request.mutable_like() = like;
  v1::Reply reply;
  CallStatus status = Call(request, &reply);
  if (!status.ok()) return status;
  if (applied != nullptr) applied->assign(reply.applied().begin(), reply.applied().end());
  if (out != nullptr) out->Swap(reply.mutable_like());
  return status;
}

CallStatus Control::ExportStyle(std::string_view name, v1::StyleFile* out) {
  v1::Request request;
  request.mutable_export_style()->set_name(std::string(name));
  return Ask(request, &v1::Reply::mutable_style_file, out);
}

CallStatus Control::ImportStyle(const v1::ImportStyle& file, v1::LikeReply* out) {
  v1::Request request;
  *request.mutable_import_style() = file;
  return Ask(request, &v1::Reply::mutable_like, out);
}

CallStatus Control::RenameStyle(std::string_view name, std::string_view to, Applied* applied) {
  v1::Request request;
  request.mutable_rename_style()->set_name(std::string(name));
  request.mutable_rename_style()->set_to(std::string(to));
  return Change(request, "", applied);
}

CallStatus Control::RemoveStyle(std::string_view name, Applied* applied) {
  v1::Request request;
  request.mutable_remove_style()->set_name(std::string(name));
  return Change(request, "", applied);
}

CallStatus Control::Explain(std::string_view performer, const v1::Explain& which,
                            v1::ExplainReply* out) {
  v1::Request request;
  request.set_performer(std::string(performer));
  *request.mutable_explain() = which;
  v1::Reply reply;
  CallStatus status = Call(request, &reply);
  if (status.ok() && out != nullptr) out->Swap(reply.mutable_explain());
  return status;
}

CallStatus Control::Preview(std::string_view style, v1::PreviewReply* out) {
  v1::Request request;
  request.mutable_preview()->set_style(std::string(style));
  return Ask(request, &v1::Reply::mutable_preview, out);
}

CallStatus Control::TakeCheckpoint(std::string_view performer, v1::Checkpoint* out) {
  v1::Request request;
  request.set_performer(std::string(performer));
  request.mutable_take_checkpoint();
  return Ask(request, &v1::Reply::mutable_checkpoint, out);
}

CallStatus Control::RestoreCheckpoint(std::string_view performer, const v1::Checkpoint& checkpoint,
                                      Applied* applied) {
  v1::Request request;
  *request.mutable_restore_checkpoint()->mutable_checkpoint() = checkpoint;
  return Change(request, performer, applied);
}

CallStatus Control::Lead() {
  v1::Request request;
  request.mutable_lead();
  v1::Reply reply;
  return Call(request, &reply);
}

CallStatus Control::Cue(std::string_view name, Applied* applied) {
  v1::Request request;
  request.mutable_cue()->set_name(std::string(name));
  return Change(request, kEveryone, applied);
}

CallStatus Control::Panic(Applied* applied) {
  v1::Request request;
  request.mutable_panic();
  return Change(request, kEveryone, applied);
}

std::string CodeName(v1::Code code) {
  const std::string& name = v1::Code_Name(code);  // "CODE_BUSY"; "" if it is not known
  constexpr std::string_view kPrefix = "CODE_";
  return name.empty() ? std::string(kPrefix) + std::to_string(static_cast<int>(code))
                      : name.substr(kPrefix.size());
}

std::string LayersText(const v1::PerformerStats& performer) {
  std::string out;
  for (const auto& layer : performer.layers()) {
    out.append(out.empty() ? "" : ", ").append(layer.part()).append(": ").append(layer.source());
    out += layer.live() ? " (live)" : " (silent)";
  }
  return out;
}

}  // namespace styled::client

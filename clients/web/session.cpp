#include "clients/web/session.h"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "clients/web/gateway.h"

namespace styled::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using nlohmann::json;

constexpr std::size_t kMaxRequestBytes = 8 << 20;  // like the daemon's limit of a Like with its
                                                   // clip
constexpr std::size_t kMaxTextBytes = 64 << 10;    // of a message as text
constexpr int kMaxRequests = 16;                   // of one browser, without reply
constexpr std::size_t kMaxNotices = 64;            // without key, queued
constexpr auto kAwait = asio::as_tuple(asio::use_awaitable);

class Session : public Browser, public std::enable_shared_from_this<Session> {
 public:
  Session(beast::tcp_stream stream, Gateway& gateway)
      : gateway_(gateway), socket_(std::move(stream)) {}

  asio::awaitable<void> Run(beast::http::request<beast::http::empty_body> request);
  void Offer(const MessagePtr& message) override;

 private:
  void Write();
  void Read(std::string_view bytes, bool text);
  void ReadText(std::string_view text);
  void ReadTopics(const json& topics, bool subscribe);
  void ReadRequest(std::string_view bytes);
  void Notice(const json& notice);
  void Complain(const std::string& what);
  void Unanswered(std::uint64_t id, const std::string& reason);
  void Answered(const client::CallStatus& status, const v1::Reply& reply);

  Gateway& gateway_;
  websocket::stream<beast::tcp_stream> socket_;
  Mailbox mailbox_;
  MessagePtr writing_;
  int requests_ = 0;
  bool open_ = false;
};

asio::awaitable<void> Session::Run(beast::http::request<beast::http::empty_body> request) {
  const auto self = shared_from_this();
  auto timeouts = websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeouts.idle_timeout = std::chrono::seconds(30);
  socket_.set_option(timeouts);
  socket_.read_message_max(kMaxRequestBytes);
  if (const auto [error] = co_await socket_.async_accept(request, kAwait); error) co_return;
  open_ = true;
  Notice({{"styleweb", STYLED_VERSION}, {"watchOnly", gateway_.options.watch_only}});
  gateway_.hub->Join(*this);
  beast::flat_buffer buffer;
  for (;;) {
    const auto [error, size] = co_await socket_.async_read(buffer, kAwait);
    if (error || (socket_.got_text() && buffer.size() > kMaxTextBytes)) break;
    Read({static_cast<const char*>(buffer.data().data()), buffer.size()}, socket_.got_text());
    buffer.consume(buffer.size());
  }
  open_ = false;
  gateway_.hub->Leave(*this);
}

void Session::Offer(const MessagePtr& message) {
  if (!open_) return;
  if (mailbox_.Put(message)) ++gateway_.counters.superseded;
  Write();
}

void Session::Write() {
  if (writing_ || !open_) return;
  writing_ = mailbox_.Pop();
  if (!writing_) return;
  socket_.text(writing_->text);
  socket_.async_write(asio::buffer(writing_->bytes),
                      [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                        const MessagePtr written = std::exchange(self->writing_, nullptr);
                        if (error) return;  // the reader ends as well
                        ++self->gateway_.counters.sent_messages;
                        self->gateway_.counters.sent_bytes += written->bytes.size();
                        self->Write();
                      });
}

void Session::Notice(const json& notice) {
  if (mailbox_.size() > Hub::kMaxTopics + kMaxNotices) return;
  Offer(std::make_shared<Message>(
      Message{"", notice.dump(-1, ' ', false, json::error_handler_t::replace), true}));
}

void Session::Complain(const std::string& what) {
  ++gateway_.counters.bad_messages;
  Notice({{"error", what}});
}

void Session::Unanswered(std::uint64_t id, const std::string& reason) {
  ++gateway_.counters.unanswered;
  Notice({{"unanswered", std::to_string(id)}, {"reason", reason}});
}

void Session::Read(std::string_view bytes, bool text) {
  if (text) return ReadText(bytes);
  ReadRequest(bytes);
}

void Session::ReadText(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object() || message.empty()) {
    return Complain("expected a JSON object such as {\"subscribe\": [\"stats/\"]}");
  }
  for (const auto& [name, value] : message.items()) {
    if (name == "subscribe" || name == "unsubscribe") {
      ReadTopics(value, name == "subscribe");
    } else {
      Complain("unknown '" + name.substr(0, 64) + "', expected subscribe or unsubscribe");
    }
  }
}

// An invalid topic does not prevent the others; the first one is reported.
void Session::ReadTopics(const json& topics, bool subscribe) {
  if (!topics.is_array()) return Complain("expected a list of topics");
  std::string wrong;
  int others = 0;
  const auto note = [&](const std::string& what) {
    if (wrong.empty()) {
      wrong = what;
    } else {
      ++others;
    }
  };
  for (const json& entry : topics) {
    if (!entry.is_string()) {
      note("expected a list of topics");
      continue;
    }
    const auto& topic = entry.get_ref<const std::string&>();
    if (!subscribe) {
      gateway_.hub->Unsubscribe(*this, topic);
      continue;
    }
    switch (gateway_.hub->Subscribe(*this, topic)) {
      case Subscribed::kOk:
        break;
      case Subscribed::kNoTopic:
        note("'" + topic.substr(0, 128) +
             "' is not a topic, expected e.g. styled/rig.anna/rig/, source/rig.anna/, body/ "
             "or stats/");
        break;
      case Subscribed::kTooMany:
        note("'" + topic + "': too many topics");
        break;
    }
  }
  if (others > 0) wrong += " (and " + std::to_string(others) + " more are wrong)";
  if (!wrong.empty()) Complain(wrong);
}

void Session::ReadRequest(std::string_view bytes) {
  v1::Request request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return Complain("expected a Request (proto/styled/v1/control.proto)");
  }
  ++gateway_.counters.requests;
  const std::uint64_t id = request.id();
  const bool asks = request.has_list() || request.has_status() || request.has_preview() ||
                    request.has_export_style() || request.has_explain();
  if (gateway_.options.watch_only && !asks) {
    v1::Reply reply;
    reply.set_id(id);
    reply.set_code(v1::CODE_UNAUTHORIZED);
    reply.set_reason("this gateway is for watching only (--watch-only)");
    Offer(std::make_shared<Message>(Message{"", Packed("", reply.SerializeAsString()), false}));
    return;
  }
  if (requests_ >= kMaxRequests) return Unanswered(id, "too many requests at once");
  const auto done = [weak = weak_from_this(), &io = gateway_.io](client::CallStatus status,
                                                                 v1::Reply reply) {
    asio::post(io, [weak, status = std::move(status), reply = std::move(reply)] {
      if (const auto self = weak.lock()) self->Answered(status, reply);
    });
  };
  if (!gateway_.asker->Ask(std::move(request), done)) {
    return Unanswered(id, "too many requests at once");
  }
  ++requests_;
}

void Session::Answered(const client::CallStatus& status, const v1::Reply& reply) {
  --requests_;
  using Kind = client::CallStatus::Kind;
  if (status.kind() == Kind::kNoAnswer || status.kind() == Kind::kGarbled) {
    return Unanswered(reply.id(), status.reason());
  }
  Offer(std::make_shared<Message>(Message{"", Packed("", reply.SerializeAsString()), false}));
}

}  // namespace

asio::awaitable<void> RunSession(beast::tcp_stream stream,
                                 beast::http::request<beast::http::empty_body> request,
                                 Gateway& gateway) {
  co_await std::make_shared<Session>(std::move(stream), gateway)->Run(std::move(request));
}

}  // namespace styled::web

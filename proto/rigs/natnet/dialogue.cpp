#include "proto/rigs/natnet/dialogue.h"

#include "proto/rigs/natnet/cursor.h"

namespace styled::natnet {
namespace {

constexpr std::size_t kNameSize = 256;  // NUL included
constexpr std::size_t kRecordSize = kNameSize + 8;
constexpr std::size_t kBitstreamSize = 270;
constexpr std::string_view kPing = "Ping";

// The text up to a NUL or the end.
std::string_view TextOf(std::span<const std::byte> bytes) noexcept {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.substr(0, text.find('\0'));
}

Version GetVersion(Reader& reader) noexcept {
  Version version;
  version.major = reader.Get<std::uint8_t>();
  version.minor = reader.Get<std::uint8_t>();
  version.build = reader.Get<std::uint8_t>();
  version.revision = reader.Get<std::uint8_t>();
  return version;
}

void PutVersion(const Version& version, Writer& writer) noexcept {
  for (const auto part : {version.major, version.minor, version.build, version.revision}) {
    writer.Put(part);
  }
}

void PutName(std::string_view name, Writer& writer) noexcept {
  name = name.substr(0, kNameSize - 1);
  writer.PutBytes(std::as_bytes(std::span(name)));
  writer.PutZeros(kNameSize - name.size());
}

}  // namespace

void DecodeConnect(std::span<const std::byte> payload, Connect& connect) noexcept {
  connect = {};
  connect.shape = Connect::Shape::kText;
  connect.name = TextOf(payload.first(std::min(payload.size(), kNameSize)));
  if (payload.size() < kRecordSize) return;
  Reader reader(payload.subspan(kNameSize));
  // Only the size distinguishes a record from the longer shape: an application may be called
  // "Ping".
  if (payload.size() < kBitstreamSize) {
    connect.shape = Connect::Shape::kRecord;
    connect.application = GetVersion(reader);
    connect.natnet = GetVersion(reader);
    return;
  }
  connect.shape = Connect::Shape::kBitstream;
  reader.Skip(8);
  connect.subscribed_only = reader.Get<std::uint8_t>() != 0;
  connect.bitstream = GetVersion(reader);
}

std::size_t EncodeConnect(const Connect& connect, std::span<std::byte> out) noexcept {
  Writer writer(out);
  switch (connect.shape) {
    case Connect::Shape::kText:
      writer.PutText(connect.name.substr(0, kNameSize - 1));
      break;
    case Connect::Shape::kRecord:
      PutName(connect.name, writer);
      PutVersion(connect.application, writer);
      PutVersion(connect.natnet, writer);
      break;
    case Connect::Shape::kBitstream:
      PutName(kPing, writer);
      writer.PutZeros(8);
      writer.Put(static_cast<std::uint8_t>(connect.subscribed_only));
      PutVersion(connect.bitstream, writer);
      writer.PutZeros(1);
      break;
  }
  return writer.Finish(MessageId::kConnect);
}

DecodeResult DecodeServerInfo(std::span<const std::byte> payload, ServerInfo& info) noexcept {
  Reader reader(payload);
  info.name = TextOf(reader.Consume(kNameSize));
  info.application = GetVersion(reader);
  info.natnet = GetVersion(reader);
  info.connection.reset();
  if (reader.ok() && info.natnet.major >= 3 && reader.left() > 0) {
    ServerInfo::Connection connection{};
    connection.clock_hz = reader.Get<std::uint64_t>();
    connection.data_port = reader.Get<std::uint16_t>();
    connection.multicast = reader.Get<std::uint8_t>() != 0;
    connection.group = reader.Get<std::array<std::uint8_t, 4>>();
    info.connection = connection;
  }
  return reader.result();
}

std::size_t EncodeServerInfo(const ServerInfo& info, std::span<std::byte> out) noexcept {
  Writer writer(out);
  PutName(info.name, writer);
  PutVersion(info.application, writer);
  PutVersion(info.natnet, writer);
  if (info.connection && info.natnet.major >= 3) {
    writer.Put(info.connection->clock_hz);
    writer.Put(info.connection->data_port);
    writer.Put(static_cast<std::uint8_t>(info.connection->multicast));
    writer.Put(info.connection->group);
  }
  return writer.Finish(MessageId::kServerInfo);
}

std::string_view DecodeRequest(std::span<const std::byte> payload) noexcept {
  return TextOf(payload);
}

std::size_t EncodeNumber(float number, std::span<std::byte> out) noexcept {
  Writer writer(out);
  writer.Put(number);
  return writer.Finish(MessageId::kResponse);
}

DecodeResult DecodeEchoRequest(std::span<const std::byte> payload, Echo& echo) noexcept {
  Reader reader(payload);
  const auto client = reader.Get<std::uint64_t>();
  if (reader.left() > 0) return DecodeResult::kTrailing;
  if (reader.ok()) echo.client = client;
  return reader.result();
}

std::size_t EncodeEchoResponse(const Echo& echo, std::span<std::byte> out) noexcept {
  Writer writer(out);
  writer.Put(echo.client);
  writer.Put(echo.server);
  return writer.Finish(MessageId::kEchoResponse);
}

}  // namespace styled::natnet

#include "tests/unit/vmc/witness.h"

#include <lo/lo.h>
#include <oscpack/osc/OscReceivedElements.h>

#include <bit>
#include <cstdio>
#include <cstring>
#include <memory>

#include "proto/rigs/vmc/osc.h"

namespace styled::vmc::testing {
namespace {

std::string Number(float value) {
  char text[16];
  std::snprintf(text, sizeof text, " %08x", std::bit_cast<unsigned>(value));
  return text;
}
std::string Number(std::int32_t value) { return " " + std::to_string(value); }

// The types that our own Arguments read; all three skip the values of other types.
std::string Describe(const osc::Message& message) {
  std::string text = std::string(message.address) + " ,";
  text += message.types;
  osc::Arguments arguments(message);
  for (const char type : message.types) {
    std::int32_t number = 0;
    float real = 0;
    std::string_view word;
    if (type == 'i' && arguments.Int(number))
      text += Number(number);
    else if (type == 'f' && arguments.Float(real))
      text += Number(real);
    else if (type == 's' && arguments.Text(word))
      text.append(" ").append(word);
    else
      break;
  }
  return text;
}

int OnLiblo(const char* path, const char* types, lo_arg** arguments, int count, lo_message /*m*/,
            void* user) {
  std::string text = std::string(path) + " ," + types;
  for (int i = 0; i < count; ++i) {
    if (types[i] == 'i')
      text += Number(arguments[i]->i);
    else if (types[i] == 'f')
      text += Number(arguments[i]->f);
    else if (types[i] == 's')
      text.append(" ").append(&arguments[i]->s);
    else
      break;
  }
  static_cast<Witness*>(user)->messages.push_back(text);
  return 0;
}

std::string Describe(const ::osc::ReceivedMessage& message) {
  const std::string types = message.TypeTags() == nullptr ? "" : message.TypeTags();
  std::string text = std::string(message.AddressPattern()) + " ," + types;
  auto argument = message.ArgumentsBegin();
  for (const char type : types) {
    if (type == 'i')
      text += Number(argument->AsInt32());
    else if (type == 'f')
      text += Number(argument->AsFloat());
    else if (type == 's')
      text.append(" ").append(argument->AsString());
    else
      break;
    ++argument;
  }
  return text;
}

void Walk(const ::osc::ReceivedBundle& bundle, Witness& witness) {
  for (auto element = bundle.ElementsBegin(); element != bundle.ElementsEnd(); ++element) {
    if (element->IsBundle()) {
      Walk(::osc::ReceivedBundle(*element), witness);
    } else {
      witness.messages.push_back(Describe(::osc::ReceivedMessage(*element)));
    }
  }
}

}  // namespace

Witness ReadOurs(std::span<const std::byte> datagram) {
  Witness witness;
  osc::Reader reader(datagram);
  osc::Message message;
  while (reader.Next(message) == osc::Reader::Step::kMessage) {
    witness.messages.push_back(Describe(message));
  }
  witness.taken = reader.result() == osc::Result::kOk;
  return witness;
}

// Through a server, which is liblo's only way to read bundles; its queue, in which bundles of the
// future wait, is off.
Witness ReadLiblo(std::span<const std::byte> datagram) {
  Witness witness;
  const std::unique_ptr<std::remove_pointer_t<lo_server>, void (*)(lo_server)> server(
      lo_server_new(nullptr, [](int, const char*, const char*) {}), lo_server_free);
  lo_server_enable_queue(server.get(), 0, 1);
  lo_server_add_method(server.get(), nullptr, nullptr, OnLiblo, &witness);
  // liblo turns the numbers in place.
  std::vector<std::byte> bytes(datagram.begin(), datagram.end());
  bytes.reserve(1);
  witness.taken = lo_server_dispatch_data(server.get(), bytes.data(), bytes.size()) > 0;
  return witness;
}

Witness ReadOscpack(std::span<const std::byte> datagram) {
  Witness witness;
  try {
    const ::osc::ReceivedPacket packet(
        reinterpret_cast<const char*>(datagram.data()),
        static_cast<::osc::osc_bundle_element_size_t>(datagram.size()));
    if (packet.IsBundle()) {
      Walk(::osc::ReceivedBundle(packet), witness);
    } else {
      witness.messages.push_back(Describe(::osc::ReceivedMessage(packet)));
    }
    witness.taken = true;
  } catch (const ::osc::Exception&) {
    witness.taken = false;
  }
  return witness;
}

}  // namespace styled::vmc::testing

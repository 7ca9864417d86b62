#include "proto/rigs/vmc/vmc.h"

#include "proto/rigs/result_name.h"

namespace styled::vmc {
namespace {

constexpr std::string_view kAvailable = "/VMC/Ext/OK", kRoot = "/VMC/Ext/Root/Pos",
                           kBone = "/VMC/Ext/Bone/Pos", kBlend = "/VMC/Ext/Blend/Val",
                           kApply = "/VMC/Ext/Blend/Apply", kThru = "/VMC/Thru/";

// Reads arguments one by one. The first one that is missing or of a wrong type determines the
// result.
class Taker {
 public:
  explicit Taker(const osc::Message& message) noexcept : arguments_(message) {}

  void Int(std::int32_t& value) noexcept { Note(ok() && arguments_.Int(value)); }
  void Float(float& value) noexcept { Note(ok() && arguments_.Float(value)); }
  void Text(std::string_view& value) noexcept { Note(ok() && arguments_.Text(value)); }
  void Place(Transform& transform) noexcept {
    for (float& value : transform.position) Float(value);
    for (float& value : transform.rotation) Float(value);
  }
  bool more() const noexcept { return ok() && !arguments_.AtEnd(); }
  bool ok() const noexcept { return result_ == DecodeResult::kOk; }
  DecodeResult result() const noexcept { return result_; }

 private:
  void Note(bool taken) noexcept {
    if (taken || !ok()) return;
    result_ = arguments_.AtEnd() ? DecodeResult::kTooFewArguments : DecodeResult::kWrongType;
  }

  osc::Arguments arguments_;
  DecodeResult result_ = DecodeResult::kOk;
};

// The protocol allows one text, alone or with one number.
DecodeResult CheckThru(std::string_view types) noexcept {
  if (types.empty()) return DecodeResult::kTooFewArguments;
  return types == "s" || types == "sf" || types == "si" ? DecodeResult::kOk
                                                        : DecodeResult::kWrongType;
}

void PutPlace(const Transform& transform, osc::Writer& writer) noexcept {
  for (const float value : transform.position) writer.Float(value);
  for (const float value : transform.rotation) writer.Float(value);
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "unknown_address", "too_few_arguments", "wrong_type"});
}

DecodeResult Decode(const osc::Message& bytes, Message& message) noexcept {
  Taker taker(bytes);
  const auto finish = [&](const auto& decoded) {
    if (taker.ok()) message = decoded;
    return taker.result();
  };
  if (bytes.address == kBone) {
    Bone bone;
    taker.Text(bone.name);
    taker.Place(bone.transform);
    return finish(bone);
  }
  if (bytes.address == kBlend) {
    Blend blend;
    taker.Text(blend.name);
    taker.Float(blend.value);
    return finish(blend);
  }
  if (bytes.address == kTimeAddress) {
    Time time;
    taker.Float(time.seconds);
    return finish(time);
  }
  if (bytes.address == kRoot) {
    Root root;
    std::string_view name;  // always "root"
    taker.Text(name);
    taker.Place(root.transform);
    return finish(root);
  }
  if (bytes.address == kAvailable) {
    Available available;
    taker.Int(available.loaded);
    for (std::int32_t* value :
         {&available.calibration_state, &available.calibration_mode, &available.tracking}) {
      if (taker.more()) taker.Int(*value);
    }
    return finish(available);
  }
  if (bytes.address == kApply) return finish(BlendApply());
  if (bytes.address.starts_with(kThru)) {
    const DecodeResult result = CheckThru(bytes.types);
    if (result == DecodeResult::kOk) message = Thru{bytes.bytes};
    return result;
  }
  return DecodeResult::kUnknownAddress;
}

void Put(const Available& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kAvailable, "iiii");
  writer.Int(message.loaded);
  writer.Int(message.calibration_state);
  writer.Int(message.calibration_mode);
  writer.Int(message.tracking);
  writer.EndMessage();
}

void Put(const Time& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kTimeAddress, "f");
  writer.Float(message.seconds);
  writer.EndMessage();
}

void Put(const Root& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kRoot, "sfffffff");
  writer.Text("root");
  PutPlace(message.transform, writer);
  writer.EndMessage();
}

void Put(const Bone& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kBone, "sfffffff");
  writer.Text(message.name);
  PutPlace(message.transform, writer);
  writer.EndMessage();
}

void Put(const Blend& message, osc::Writer& writer) noexcept {
  writer.BeginMessage(kBlend, "sf");
  writer.Text(message.name);
  writer.Float(message.value);
  writer.EndMessage();
}

void Put(const BlendApply& /*message*/, osc::Writer& writer) noexcept {
  writer.BeginMessage(kApply, "");
  writer.EndMessage();
}

void Put(const Thru& message, osc::Writer& writer) noexcept { writer.Raw(message.bytes); }

}  // namespace styled::vmc

#include "proto/rigs/natnet/model.h"

#include "proto/rigs/natnet/cursor.h"

namespace styled::natnet {
namespace {

enum Kind : std::int32_t {
  kMarkerSet = 0,
  kRigidBody = 1,
  kSkeleton = 2,
  kForcePlate = 3,
  kDevice = 4,
  kCamera = 5
};

void SkipNames(Reader& reader) noexcept {
  for (std::size_t n = reader.GetCount(1); n > 0; --n) reader.GetText();
}

void SkipMarkerSet(Reader& reader) noexcept {
  reader.GetText();
  SkipNames(reader);
}

// A rigid body or a bone: both have the same record, in which only rigid bodies have markers.
BoneDescription GetBone(Reader& reader, Version version) noexcept {
  BoneDescription bone;
  bone.name = reader.GetText();
  bone.id = reader.Get<std::int32_t>();
  bone.parent = reader.Get<std::int32_t>();
  bone.offset_m = reader.Get<std::array<float, 3>>();
  if (version >= Version{4, 2}) reader.Skip(16);  // rotation offset
  if (version.major < 3) return bone;
  const std::size_t markers = reader.GetCount(16);
  reader.Skip(markers * 16);  // positions, then active labels
  if (version.major < 4) return bone;
  for (std::size_t i = 0; i < markers; ++i) reader.GetText();
  return bone;
}

void GetRigidBody(Reader& reader, Version version, Model& model) noexcept {
  const BoneDescription body = GetBone(reader, version);
  ++model.rigid_body_count;
  if (!reader.ok() || model.rigid_bodies_read == kMaxRigidBodies) return;
  model.rigid_bodies[model.rigid_bodies_read++] = {body.name, body.id, body.parent};
}

void GetSkeleton(Reader& reader, Version version, Model& model) noexcept {
  const std::string_view name = reader.GetText();
  const auto id = reader.Get<std::int32_t>();
  const std::size_t bones = reader.GetCount(21);
  const bool keep = model.skeleton_count < kMaxSkeletons && bones <= kMaxBones;
  if (!keep) {
    for (std::size_t i = 0; i < bones && reader.ok(); ++i) GetBone(reader, version);
    ++model.skeletons_left_out;
    return;
  }
  SkeletonDescription& skeleton = model.skeletons[model.skeleton_count++];
  skeleton.name = name;
  skeleton.id = id;
  skeleton.bone_count = bones;
  for (std::size_t i = 0; i < bones; ++i) skeleton.bones[i] = GetBone(reader, version);
}

// Reads four corners, as jeguzzi/natnet_py does. TimSchneider42/python-natnet-client reads three,
// but a plate has four.
void SkipForcePlate(Reader& reader) noexcept {
  reader.Skip(4);                          // id
  reader.GetText();                        // serial number
  reader.Skip(4 * (5 + 12 * 12 + 4 * 3));  // size, origin, calibration, corners
  reader.Skip(8);                          // type, kind of data
  SkipNames(reader);
}

void SkipDevice(Reader& reader) noexcept {
  reader.Skip(4);
  reader.GetText();
  reader.GetText();
  reader.Skip(8);
  SkipNames(reader);
}

// Returns false for a data set of a kind that cannot be skipped.
bool GetDataSet(std::int32_t kind, Reader& reader, Version version, Model& model) noexcept {
  switch (kind) {
    case kMarkerSet:
      SkipMarkerSet(reader);
      return true;
    case kRigidBody:
      GetRigidBody(reader, version, model);
      return true;
    case kSkeleton:
      GetSkeleton(reader, version, model);
      return true;
    case kForcePlate:
      if (version.major < 3) return false;  // 2.9 and 2.10: the layout is unknown
      SkipForcePlate(reader);
      return true;
    case kDevice:
      if (version.major < 3) return false;
      SkipDevice(reader);
      return true;
    case kCamera:
      reader.GetText();
      reader.Skip(28);
      return true;
    default:
      return false;
  }
}

void PutBone(const BoneDescription& bone, Version version, Writer& writer) noexcept {
  writer.PutText(bone.name);
  writer.Put(bone.id);
  writer.Put(bone.parent);
  writer.Put(bone.offset_m);
  if (version >= Version{4, 2}) writer.Put(std::array<float, 4>{0, 0, 0, 1});
  if (version.major >= 3) writer.Put<std::int32_t>(0);  // markers
}

}  // namespace

DecodeResult DecodeModel(std::span<const std::byte> payload, Version version,
                         Model& model) noexcept {
  if (version < kOldest) return DecodeResult::kOldVersion;
  model.rigid_body_count = model.rigid_bodies_read = 0;
  model.skeleton_count = model.skeletons_left_out = 0;
  model.complete = true;
  Reader reader(payload);
  for (std::size_t n = reader.GetCount(5); n > 0 && reader.ok(); --n) {
    const auto kind = reader.Get<std::int32_t>();
    if (version < kSized) {
      if (GetDataSet(kind, reader, version, model)) continue;
      model.complete = false;
      break;
    }
    const std::size_t size = reader.GetCount(1);
    Reader part = reader.Sub(size);
    // The size skips unused data sets, and in later bitstreams additions at a skeleton's end.
    if (kind == kSkeleton) {
      GetSkeleton(part, version, model);
      reader.Join(part, IsKnown(version));
    } else if (kind == kRigidBody) {
      GetRigidBody(part, version, model);  // what is wrong with it ends with its size
    }
  }
  return reader.result();
}

std::size_t EncodeModel(const Model& model, Version version, std::span<std::byte> out) noexcept {
  Writer writer(out);
  writer.Put(static_cast<std::int32_t>(model.rigid_bodies_read + model.skeleton_count));
  for (std::size_t b = 0; b < model.rigid_bodies_read; ++b) {
    const RigidBodyDescription& body = model.rigid_bodies[b];
    writer.Put<std::int32_t>(kRigidBody);
    const std::size_t mark = version >= kSized ? writer.Mark() : 0;
    PutBone({body.name, body.id, body.parent, {}}, version, writer);
    if (version >= kSized) writer.SetSize(mark);
  }
  for (std::size_t s = 0; s < model.skeleton_count; ++s) {
    const SkeletonDescription& skeleton = model.skeletons[s];
    writer.Put<std::int32_t>(kSkeleton);
    const std::size_t mark = version >= kSized ? writer.Mark() : 0;
    writer.PutText(skeleton.name);
    writer.Put(skeleton.id);
    writer.Put(static_cast<std::int32_t>(skeleton.bone_count));
    for (std::size_t b = 0; b < skeleton.bone_count; ++b) {
      PutBone(skeleton.bones[b], version, writer);
    }
    if (version >= kSized) writer.SetSize(mark);
  }
  return writer.Finish(MessageId::kModelDef);
}

}  // namespace styled::natnet

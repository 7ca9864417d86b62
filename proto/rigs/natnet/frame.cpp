#include "proto/rigs/natnet/frame.h"

#include "proto/rigs/natnet/cursor.h"

namespace styled::natnet {
namespace {

constexpr Version kPlates{2, 9};    // force plates
constexpr Version kDevices{2, 11};  // 3.0 was called 2.11 at first

// Size of the record of a rigid body or bone. Of the sources read,
// TimSchneider42/python-natnet-client, jeguzzi/natnet_py and IMRCLab/libmotioncapture agree on it
// for all versions, and mje-nz/python_natnet from 3.0 on; the latter has 4 more bytes after a 2.x
// body's markers, which real 2.7 and 2.9 packets do not have.
std::size_t BodySize(Version version) noexcept { return version.major < 3 ? 42 : 38; }

Bone GetBody(Reader& reader, Version version) noexcept {
  Bone body;
  body.id = reader.Get<std::int32_t>();
  body.position_m = reader.Get<std::array<float, 3>>();
  body.rotation = reader.Get<std::array<float, 4>>();
  if (version.major < 3) {
    reader.Skip(reader.GetCount(20) * 20);  // markers: positions, ids, sizes
  }
  reader.Skip(4);  // mean error
  body.tracked = (reader.Get<std::uint16_t>() & 1U) != 0;
  return body;
}

// Reads a section: the number of elements, from 4.1 on also their size in bytes (counted after the
// size field), then the elements, each by `get`. This follows TimSchneider42/python-natnet-client,
// whose authors tested it with Motive 3.1; IMRCLab/libmotioncapture skips assets by this size. A
// later bitstream's elements may be longer, so there only `kept` sections are read and the others
// are skipped.
template <typename Get>
std::size_t GetSection(Reader& reader, Version version, std::size_t smallest, bool kept,
                       Get get) noexcept {
  const std::size_t count = reader.GetCount(version < kSized ? smallest : 1);
  if (version < kSized) {
    for (std::size_t i = 0; i < count && reader.ok(); ++i) get(reader);
    return count;
  }
  const std::size_t size = reader.GetCount(1);
  Reader part = reader.Sub(size);
  const bool known = IsKnown(version);
  if (known && count > part.left() / smallest) part.Fail(DecodeResult::kBadCount);
  if (known || kept) {
    for (std::size_t i = 0; i < count && part.ok(); ++i) get(part);
  }
  reader.Join(part, known);
  return count;
}

void GetSkeleton(Reader& reader, Version version, Frame& frame) noexcept {
  const auto id = reader.Get<std::int32_t>();
  const std::size_t bones = reader.GetCount(BodySize(version));
  if (frame.skeleton_count == kMaxSkeletons || bones > kMaxBones) {
    for (std::size_t i = 0; i < bones && reader.ok(); ++i) GetBody(reader, version);
    ++frame.skeletons_left_out;
    return;
  }
  Skeleton& skeleton = frame.skeletons[frame.skeleton_count++];
  skeleton.id = id;
  skeleton.bone_count = bones;
  for (std::size_t i = 0; i < bones; ++i) skeleton.bones[i] = GetBody(reader, version);
}

// Force plates and devices have the same form.
void SkipAnalog(Reader& reader) noexcept {
  reader.Skip(4);  // id
  for (std::size_t channels = reader.GetCount(4); channels > 0; --channels) {
    reader.Skip(reader.GetCount(4) * 4);
  }
}

void GetSections(Reader& reader, Version version, Frame& frame) noexcept {
  GetSection(reader, version, 5, false, [](Reader& r) {  // marker sets
    r.GetText();
    r.Skip(r.GetCount(12) * 12);
  });
  GetSection(reader, version, 12, false, [](Reader& r) { r.Skip(12); });  // unlabelled markers
  frame.rigid_body_count = GetSection(reader, version, BodySize(version), false, [&](Reader& r) {
    const Bone body = GetBody(r, version);
    if (frame.rigid_bodies_read < kMaxRigidBodies) {
      frame.rigid_bodies[frame.rigid_bodies_read++] = body;
    }
  });
  GetSection(reader, version, 8, true, [&](Reader& r) { GetSkeleton(r, version, frame); });
  if (version >= kSized) {
    GetSection(reader, version, 12, false, [](Reader& r) {  // assets
      r.Skip(4);
      r.Skip(r.GetCount(38) * 38);  // rigid bodies
      r.Skip(r.GetCount(26) * 26);  // markers
    });
  }
  const std::size_t marker_size = version.major < 3 ? 22 : 26;
  GetSection(reader, version, marker_size, false,
             [marker_size](Reader& r) { r.Skip(marker_size); });  // labelled markers
  if (version >= kPlates) GetSection(reader, version, 8, false, SkipAnalog);
  if (version >= kDevices) GetSection(reader, version, 8, false, SkipAnalog);
}

}  // namespace

DecodeResult DecodeFrame(std::span<const std::byte> payload, Version version,
                         Frame& frame) noexcept {
  if (version < kOldest) return DecodeResult::kOldVersion;
  frame.skeleton_count = frame.skeletons_left_out = frame.rigid_bodies_read = 0;
  Reader reader(payload);
  frame.number = reader.Get<std::int32_t>();
  GetSections(reader, version, frame);
  if (version.major < 3) reader.Skip(4);  // the software's latency
  frame.timecode = reader.Get<std::uint32_t>();
  frame.timecode_subframe = reader.Get<std::uint32_t>();
  frame.timestamp_s = reader.Get<double>();
  frame.exposure_ticks = frame.received_ticks = frame.transmit_ticks = 0;
  if (version.major >= 3) {
    frame.exposure_ticks = reader.Get<std::uint64_t>();
    frame.received_ticks = reader.Get<std::uint64_t>();
    frame.transmit_ticks = reader.Get<std::uint64_t>();
  }
  if (version >= kSized) reader.Skip(8);  // PTP time
  frame.params = reader.Get<std::uint16_t>();
  reader.Skip(4);  // end tag
  if (version < kSized && reader.left() > 0) return DecodeResult::kTrailing;
  return reader.result();
}

namespace {

void PutBody(const Bone& body, Version version, Writer& writer) noexcept {
  writer.Put(body.id);
  writer.Put(body.position_m);
  writer.Put(body.rotation);
  if (version.major < 3) writer.Put<std::int32_t>(0);  // markers
  writer.Put(0.0F);                                    // mean error
  writer.Put(static_cast<std::uint16_t>(body.tracked));
}

void PutEmptySection(Version version, Writer& writer) noexcept {
  writer.Put<std::int32_t>(0);
  if (version >= kSized) writer.Put<std::int32_t>(0);
}

void PutRigidBodies(const Frame& frame, Version version, Writer& writer) noexcept {
  writer.Put(static_cast<std::int32_t>(frame.rigid_bodies_read));
  const std::size_t mark = version >= kSized ? writer.Mark() : 0;
  for (std::size_t b = 0; b < frame.rigid_bodies_read; ++b) {
    PutBody(frame.rigid_bodies[b], version, writer);
  }
  if (version >= kSized) writer.SetSize(mark);
}

void PutSkeletons(const Frame& frame, Version version, Writer& writer) noexcept {
  writer.Put(static_cast<std::int32_t>(frame.skeleton_count));
  const std::size_t mark = version >= kSized ? writer.Mark() : 0;
  for (std::size_t s = 0; s < frame.skeleton_count; ++s) {
    const Skeleton& skeleton = frame.skeletons[s];
    writer.Put(skeleton.id);
    writer.Put(static_cast<std::int32_t>(skeleton.bone_count));
    for (std::size_t b = 0; b < skeleton.bone_count; ++b) {
      PutBody(skeleton.bones[b], version, writer);
    }
  }
  if (version >= kSized) writer.SetSize(mark);
}

}  // namespace

std::size_t EncodeFrame(const Frame& frame, Version version, std::span<std::byte> out) noexcept {
  Writer writer(out);
  writer.Put(frame.number);
  for (int i = 0; i < 2; ++i) PutEmptySection(version, writer);  // marker sets, other markers
  PutRigidBodies(frame, version, writer);
  PutSkeletons(frame, version, writer);
  if (version >= kSized) PutEmptySection(version, writer);    // assets
  PutEmptySection(version, writer);                           // labelled markers
  if (version >= kPlates) PutEmptySection(version, writer);   // force plates
  if (version >= kDevices) PutEmptySection(version, writer);  // devices
  if (version.major < 3) writer.Put(0.0F);                    // latency
  writer.Put(frame.timecode);
  writer.Put(frame.timecode_subframe);
  writer.Put(frame.timestamp_s);
  if (version.major >= 3) {
    writer.Put(frame.exposure_ticks);
    writer.Put(frame.received_ticks);
    writer.Put(frame.transmit_ticks);
  }
  if (version >= kSized) writer.Put<std::uint64_t>(0);  // PTP time
  writer.Put(frame.params);
  writer.Put<std::int32_t>(0);  // end tag
  return writer.Finish(MessageId::kFrameOfData);
}

}  // namespace styled::natnet

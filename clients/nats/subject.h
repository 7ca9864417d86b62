#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace styled::stylenats {

// Names of the daemon in NATS subjects and keys. Both are tokens with dots between them, and a
// performer's id has a dot of its own ("rig.sim"), so every name is escaped: a byte outside
// [A-Za-z0-9_-] is "=XX", its value in upper-case hexadecimal ("rig=2Esim"). "=" is legal in
// subjects and in keys of a KV bucket. Any thread; allocates. Pinned by
// tests/unit/nats/subject_test.cpp.
std::string Escape(std::string_view name);

// The inverse of Escape. Empty for text that Escape does not write: an empty token, a byte that is
// not allowed, lower-case or missing digits, an escape of a byte that needs none. Two different
// tokens are therefore never the same name.
std::optional<std::string> Unescape(std::string_view token);

// The stream of the audience tier: every fourth canonical frame (AudienceTier).
inline constexpr std::string_view kAudienceStream = "canonical30";
inline constexpr std::string_view kBucket = "styled";  // of the KV store

// "styled.SITE.PERFORMER.STREAM": a frame. STREAM is "rig", "canonical", kAudienceStream or the
// name of an [[output]].
std::string FrameSubject(std::string_view site, std::string_view performer,
                         std::string_view stream);
// "styled.SITE.PERFORMER.STREAM.body": the Body of that stream's frames, for recordings and for
// readers without the bucket.
std::string BodySubject(std::string_view site, std::string_view performer, std::string_view stream);
// "styledctl.SITE": requests. A tree of its own, so that a permission for "styled.>" does not
// include the commands.
std::string ControlSubject(std::string_view site);
// "SITE.body.PERFORMER.STREAM", a key: the Body of a stream.
std::string BodyKey(std::string_view site, std::string_view performer, std::string_view stream);
// "SITE.performer.PERFORMER", a key: the performer's style and state.
std::string PerformerKey(std::string_view site, std::string_view performer);

}  // namespace styled::stylenats

#include "daemon/perform/merge/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "daemon/source/face.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/support/units.h"

namespace styled::pipeline {
namespace {

using Bytes = std::vector<std::byte>;

Bytes Encoded(const std::map<std::string, float>& weights, const std::string& thru = "") {
  source::Face face;
  for (const auto& [name, weight] : weights) face.expressions.push_back({name, weight});
  if (!thru.empty()) face.thru.push_back(std::as_bytes(std::span(thru)));
  Bytes bytes(4096);
  bytes.resize(EncodeFace(face, bytes));
  return bytes;
}

v1::SourceFrame Parsed(std::span<const std::byte> face) {
  v1::SourceFrame frame;
  EXPECT_TRUE(frame.ParseFromArray(face.data(), static_cast<int>(face.size())));
  return frame;
}

source::SourceFrame Frame(const Bytes& face, std::uint64_t sequence, std::uint64_t session = 1) {
  source::SourceFrame frame;
  frame.session = session;
  frame.sequence = sequence;
  frame.face = face;
  return frame;
}

using support::kMs;

bool Accepts(FaceLayer& layer, const source::SourceFrame& frame, std::int64_t now_ns) {
  return layer.Accept(frame, now_ns) == MergedPart::kAccepted;
}

TEST(FaceLayer, WithoutAFaceThePerformersOwnIsShown) {
  FaceLayer layer;
  const Bytes own = Encoded({{"Joy", 1.0F}});
  EXPECT_EQ(layer.Over(own, 5).data(), own.data());
}

TEST(FaceLayer, AnOlderFrameIsRefused) {
  FaceLayer layer;
  const Bytes face = Encoded({{"jawOpen", 0.5F}});
  EXPECT_TRUE(Accepts(layer, Frame(face, 5), 0));
  EXPECT_FALSE(Accepts(layer, Frame(face, 5), 0));
  EXPECT_FALSE(Accepts(layer, Frame(face, 4), 0));
  EXPECT_TRUE(Accepts(layer, Frame(face, 0, 3), 0)) << "another session";
}

TEST(FaceLayer, ExpressionsReplaceThePerformersAndMessagesPassUnchanged) {
  FaceLayer layer;
  const Bytes face = Encoded({{"jawOpen", 0.5F}}), own = Encoded({{"Joy", 1.0F}}, "/VMC/Thru/a");
  ASSERT_TRUE(Accepts(layer, Frame(face, 1), 0));
  const auto shown = Parsed(layer.Over(own, 100 * kMs));
  ASSERT_EQ(shown.expressions_size(), 1);
  EXPECT_EQ(shown.expressions(0).name(), "jawOpen");
  EXPECT_EQ(shown.expressions(0).value(), 0.5F);
  ASSERT_EQ(shown.thru_size(), 1);
  EXPECT_EQ(shown.thru(0), "/VMC/Thru/a");
}

TEST(FaceLayer, ASilentFaceIsHeldThenFadesThenThePerformersOwnReturns) {
  FaceLayer layer;
  const Bytes face = Encoded({{"a", 0.8F}, {"b", 0.0F}}), own = Encoded({{"Joy", 1.0F}});
  ASSERT_TRUE(Accepts(layer, Frame(face, 1), 0));
  const auto at = [&](std::int64_t ms) {
    return Parsed(layer.Over(own, ms * kMs)).expressions(0).value();
  };
  EXPECT_FLOAT_EQ(at(500), 0.8F);
  EXPECT_FLOAT_EQ(at(750), 0.4F);
  EXPECT_FLOAT_EQ(at(1000), 0);
  EXPECT_FLOAT_EQ(at(1999), 0);
  EXPECT_EQ(Parsed(layer.Over(own, 2001 * kMs)).expressions(0).name(), "Joy");
  ASSERT_TRUE(Accepts(layer, Frame(face, 2), 5000 * kMs));
  EXPECT_FLOAT_EQ(at(5001), 0.8F);
}

TEST(FaceLayer, AppearanceAndSilenceAreReportedOnce) {
  FaceLayer layer;
  EXPECT_EQ(layer.Change(0), 0);
  ASSERT_TRUE(Accepts(layer, Frame(Encoded({{"a", 0.8F}}), 1), 0));
  EXPECT_EQ(layer.Change(10 * kMs), 1);
  EXPECT_EQ(layer.Change(900 * kMs), 0);
  EXPECT_EQ(layer.Change(1001 * kMs), -1);
  EXPECT_EQ(layer.Change(5000 * kMs), 0);
  ASSERT_TRUE(Accepts(layer, Frame(Encoded({{"a", 0.8F}}), 2), 6000 * kMs));
  EXPECT_EQ(layer.Change(6001 * kMs), 1);
}

// A counter that jumps must not keep a face out for good, as a second phone must not show up in it.
TEST(FaceLayer, AFrameFromTheFutureAndASecondPhoneChangeNothing) {
  FaceLayer layer;
  const Bytes face = Encoded({{"jawOpen", 0.5F}}), other = Encoded({{"jawOpen", 0.9F}});
  ASSERT_TRUE(Accepts(layer, Frame(face, 1), 0));
  EXPECT_EQ(layer.Accept(Frame(other, 1ULL << 60U), 10 * kMs), runtime::Counter::kPipelineFarAhead);
  EXPECT_EQ(layer.Accept(Frame(other, 1, 8), 10 * kMs), runtime::Counter::kPipelineSecondSender);
  EXPECT_TRUE(Accepts(layer, Frame(face, 2), 20 * kMs));
  EXPECT_EQ(Parsed(layer.Over({}, 20 * kMs)).expressions(0).value(), 0.5F);
  EXPECT_TRUE(Accepts(layer, Frame(other, 1, 8), 600 * kMs)) << "the first is silent";
}

// Arrays that are not faces come from a performer's own protocol; nothing of it may be read beyond
// its end.
TEST(FaceLayer, BytesThatAreNotAFaceAreRefused) {
  FaceLayer layer;
  const Bytes whole = Encoded({{"jawOpen", 0.5F}}, "/VMC/Thru/a");
  const std::size_t expression_size = whole.size() - source::PassedOn(whole).size();
  ASSERT_GT(expression_size, 0U);
  ASSERT_LT(expression_size, whole.size());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto passed_on = source::PassedOn(cut);
    if (size < whole.size()) {
      EXPECT_TRUE(passed_on.empty()) << size << ": half a message";
    } else {
      EXPECT_EQ(passed_on.data() + passed_on.size(), cut.data() + cut.size()) << size;
      EXPECT_EQ(passed_on.size(), size - expression_size) << size;
    }
    if (size > 0) EXPECT_TRUE(Accepts(layer, Frame(cut, size), 0)) << size;
    // As old as it fades: the values are scaled in place, and nothing is added.
    const auto shown = layer.Over(cut, 700 * kMs);
    EXPECT_EQ(shown.size(), cut.size() + passed_on.size()) << size;
  }
  const Bytes absurd(40, std::byte{0xFF});
  EXPECT_TRUE(source::PassedOn(absurd).empty());
  ASSERT_TRUE(Accepts(layer, Frame(absurd, 1000), 0));
  const auto shown = layer.Over(absurd, 700 * kMs);
  EXPECT_TRUE(std::ranges::equal(shown, absurd)) << "nothing of it is a value to scale";
}

TEST(Layers, AFaceIsShownOnItsPerformerOnly) {
  Layers layers;
  config::Source stage, phone;
  phone.merge_into = "stage.anna";
  layers.Set({stage, phone, phone});
  EXPECT_EQ(layers.Of(0), nullptr);
  EXPECT_EQ(layers.Of(7), nullptr);
  ASSERT_NE(layers.Of(2), nullptr);
  const Bytes face = Encoded({{"jawOpen", 0.5F}}), own = Encoded({{"Joy", 1.0F}});
  ASSERT_EQ(layers.Of(2)->Accept(Frame(face, 1), 0), MergedPart::kAccepted);
  EXPECT_TRUE(layers.FingersOf("stage.anna").empty());
  EXPECT_EQ(Parsed(layers.FaceOf("stage.bob", true, own, 0)).expressions(0).name(), "Joy");
  EXPECT_EQ(Parsed(layers.FaceOf("stage.anna", false, own, 0)).expressions(0).name(), "jawOpen");
}

TEST(Layers, AFaceWithoutANameIsTheOnlyPerformers) {
  Layers layers;
  config::Source phone;
  phone.merge_into = config::kOnlyPerformer;
  layers.Set({config::Source(), phone});
  const Bytes face = Encoded({{"jawOpen", 0.5F}}), own = Encoded({{"Joy", 1.0F}});
  ASSERT_EQ(layers.Of(1)->Accept(Frame(face, 1), 0), MergedPart::kAccepted);
  const auto shown = [&](const std::string& performer, bool alone) {
    return Parsed(layers.FaceOf(performer, alone, own, 0)).expressions(0).name() == "jawOpen";
  };
  EXPECT_EQ(layers.Into(1), "*");
  EXPECT_FALSE(shown("stage.anna", false)) << "of two, neither is named";
  EXPECT_FALSE(shown("stage.ben", false));
  EXPECT_TRUE(shown("stage.anna", true));
  EXPECT_FALSE(shown("stage.ben", false)) << "another one comes";
  EXPECT_TRUE(shown("stage.anna", false)) << "it stays theirs";
  EXPECT_TRUE(shown("stage.ben", true)) << "the first one leaves";
  EXPECT_FALSE(shown("stage.anna", false));
  EXPECT_EQ(layers.Into(1), "stage.ben");
  const std::string longest(65, 'x');
  EXPECT_TRUE(shown(longest, true));
}

TEST(Layers, ASourceWhoseDataReachNoPerformerSaysWhy) {
  Layers layers;
  config::Source named, follows;
  named.merge_into = "stage.anna";
  follows.merge_into = config::kOnlyPerformer;
  layers.Set({config::Source(), named, follows});
  const std::vector<std::string_view> other = {"stage.stage"}, both = {"a.a", "b.b"},
                                      many = {"a.a", "b.b", "c.c", "d.d", "e.e"},
                                      anna = {"stage.anna"};
  EXPECT_EQ(layers.Stray(1, other, 0), "") << "nothing arrives";
  const Bytes face = Encoded({{"jawOpen", 0.5F}});
  for (const int source : {1, 2}) {
    ASSERT_EQ(layers.Of(source)->Accept(Frame(face, 1), 0), MergedPart::kAccepted);
  }
  EXPECT_EQ(layers.Stray(0, other, 0), "");
  EXPECT_EQ(layers.Stray(7, other, 0), "");
  EXPECT_EQ(layers.Stray(1, anna, 0), "");
  EXPECT_EQ(layers.Stray(1, other, 0),
            "its data are for stage.anna, who is not here; here is stage.stage");
  EXPECT_EQ(layers.Stray(1, {}, 0),
            "its data are for stage.anna, who is not here; no performer is here");
  EXPECT_EQ(layers.Stray(2, {}, 0), "no performer is here");
  EXPECT_EQ(layers.Stray(2, other, 0), "") << "the next frame shows it";
  EXPECT_EQ(layers.Stray(2, both, 0),
            "here are a.a, b.b: merge_into must name the one who gets its data");
  EXPECT_EQ(layers.Stray(1, many, 0),
            "its data are for stage.anna, who is not here; here are a.a, b.b, c.c and 2 more");
  EXPECT_EQ(layers.Stray(1, other, 600 * kMs), "") << "silent";
}

}  // namespace
}  // namespace styled::pipeline

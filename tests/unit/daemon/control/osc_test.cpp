#include "daemon/control/osc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lo/lo.h>

#include <cstdarg>

namespace styled::control {
namespace {

using testing::HasSubstr;

// A message as liblo writes it, which is not ours.
class OscTest : public testing::Test {
 protected:
  struct Free {
    void operator()(lo_message message) const { lo_message_free(message); }
  };
  Result<v1::Request> Read(const std::string& address, const char* types = "", ...) {
    const std::unique_ptr<std::remove_pointer_t<lo_message>, Free> message(lo_message_new());
    va_list values;
    va_start(values, types);
    for (const char* type = types; *type != '\0'; ++type) {
      if (*type == 's') lo_message_add_string(message.get(), va_arg(values, const char*));
      if (*type == 'f') {
        lo_message_add_float(message.get(), static_cast<float>(va_arg(values, double)));
      }
      if (*type == 'i') lo_message_add_int32(message.get(), va_arg(values, int));
    }
    va_end(values);
    std::size_t size = 0;
    void* const bytes = lo_message_serialise(message.get(), address.c_str(), nullptr, &size);
    bytes_.assign(static_cast<std::byte*>(bytes), static_cast<std::byte*>(bytes) + size);
    free(bytes);
    vmc::osc::Reader reader(bytes_);
    vmc::osc::Message read;
    EXPECT_EQ(reader.Next(read), vmc::osc::Reader::Step::kMessage);
    return ReadOsc(read);
  }
  std::vector<std::byte> bytes_;
};

TEST_F(OscTest, ASliderOfAStyleByHandHasAnAddress) {
  const auto stoop = Read("/styled/rig.anna/design/stoop", "f", 28.0).value();
  EXPECT_EQ(stoop.performer(), "rig.anna");
  ASSERT_TRUE(stoop.like().has_design());
  EXPECT_EQ(stoop.like().design().sliders().at("stoop"), 28);
  EXPECT_EQ(stoop.like().name(), "") << "the daemon names it";
  EXPECT_EQ(Read("/styled/all/design/energy", "i", 1).value().performer(), "*");
  EXPECT_EQ(Read("/styled/rig.anna/design", "s", "sneaky").value().like().design().preset(),
            "sneaky");
  EXPECT_THAT(Read("/styled/rig.anna/design/stoop", "s", "much").status().message(),
              HasSubstr("expected a number"));
  EXPECT_FALSE(Read("/styled/design/stoop", "f", 1.0).ok());
}

TEST_F(OscTest, EveryAddressIsTheRequestOfItsName) {
  const auto style = Read("/styled/rig.anna/style", "sfi", "elderly", 0.8, 500).value();
  EXPECT_EQ(style.performer(), "rig.anna");
  EXPECT_EQ(style.set().mix(0).style(), "elderly");
  EXPECT_FLOAT_EQ(style.set().strength(), 0.8F);
  EXPECT_EQ(style.set().transition_ms(), 500);
  EXPECT_FALSE(Read("/styled/all/style", "s", "elderly").value().set().has_strength());
  EXPECT_EQ(Read("/styled/all/style", "s", "elderly").value().performer(), "*");
  EXPECT_EQ(Read("/styled/*/strength", "i", 1).value().performer(), "*");
  const auto mix = Read("/styled/rig.a/mix", "sfsf", "a", 0.25, "b", 0.5).value();
  ASSERT_EQ(mix.set().mix_size(), 2);
  EXPECT_EQ(mix.set().mix(1).weight(), 0.5F);
  EXPECT_EQ(Read("/styled/rig.a/transition", "f", 250.0).value().set().transition_ms(), 250);
  const auto preset = Read("/styled/rig.a/preset", "sf", "p", 100.0).value();
  EXPECT_EQ(preset.preset().name(), "p");
  EXPECT_EQ(preset.preset().transition_ms(), 100);
  for (const char* address : {"/styled/rig.a/parts", "/styled/rig.a/only"}) {
    EXPECT_EQ(Read(address, "s", "arms,head").value().set().parts_size(), 3);
  }
  for (const char* address : {"/styled/rig.a/input_style", "/styled/rig.a/from"}) {
    EXPECT_EQ(Read(address, "s", "old").value().set().input_style(), "old");
  }
  EXPECT_TRUE(Read("/styled/rig.a/absolute", "i", 1).value().set().absolute());
  EXPECT_EQ(Read("/styled/rig.a/root", "s", "stride").value().set().root(), v1::ROOT_STRIDE);
  EXPECT_EQ(Read("/styled/rig.a/vary", "i", 7).value().set().vary(), 7);
  EXPECT_TRUE(Read("/styled/rig.a/vary_each", "i", 1).value().set().vary_each());
  EXPECT_EQ(Read("/styled/rig.a/amount", "f", 0.5).value().set().vary_amount(), 0.5F);
  EXPECT_EQ(Read("/styled/rig.a/drift", "f", 5.0).value().set().drift_s(), 5);
  EXPECT_TRUE(Read("/styled/rig.a/mirror", "i", 1).value().set().mirror());
  EXPECT_FALSE(Read("/styled/rig.a/mirror", "f", 0.0).value().set().mirror());
  EXPECT_TRUE(Read("/styled/rig.a/pin", "i", 1).value().pin().pinned());
  EXPECT_FALSE(Read("/styled/rig.a/pin", "f", 0.0).value().pin().pinned());
  EXPECT_TRUE(Read("/styled/rig.a/clear").value().set().clear());
  EXPECT_TRUE(Read("/styled/rig.a/reset").value().has_reset());
  const auto learn = Read("/styled/rig.a/learn", "si", "pirate", 5).value();
  EXPECT_EQ(learn.like().name(), "pirate");
  EXPECT_EQ(learn.like().learn_s(), 5);
  EXPECT_EQ(Read("/styled/rig.a/learn", "s", "pirate").value().like().learn_s(), 8);
  EXPECT_FALSE(Read("/styled/rig.a/learn").ok());
  EXPECT_FALSE(Read("/styled/rig.a/learn", "sf", "pirate", 0.0).ok());
  EXPECT_EQ(Read("/styled/cue", "s", "entrance").value().cue().name(), "entrance");
  EXPECT_EQ(Read("/styled/cue/entrance").value().cue().name(), "entrance");
  EXPECT_EQ(Read("/styled/cue/entrance", "f", 1.0).value().cue().name(), "entrance");
  EXPECT_TRUE(Read("/styled/panic").value().has_panic());
  EXPECT_TRUE(Read("/styled/panic", "i", 1).value().has_panic());
}

TEST_F(OscTest, AReleasedButtonRequestsNothing) {
  for (const char* address : {"/styled/panic", "/styled/cue/entrance"}) {
    const auto released = Read(address, "f", 0.0);
    ASSERT_TRUE(released.ok());
    EXPECT_EQ(released.value().command_case(), v1::Request::COMMAND_NOT_SET);
  }
}

TEST_F(OscTest, AnErrorIsNotAnsweredByAnother) {
  const auto error = Read("/styled/error", "ss", "/styled/panic", "why");
  ASSERT_TRUE(error.ok());
  EXPECT_EQ(error.value().command_case(), v1::Request::COMMAND_NOT_SET);
}

TEST_F(OscTest, InvalidMessagesAreRefusedWithTheReason) {
  const auto why = [](const Result<v1::Request>& read) {
    return read.ok() ? "none" : read.status().message();
  };
  EXPECT_EQ(why(Read("/styled/rig.a/strength", "s", "high")),
            "/styled/rig.a/strength: expected a number from 0 to 1.5");
  EXPECT_THAT(why(Read("/styled/rig.a/strength", "ff", 1.0, 2.0)), HasSubstr("expected a number"));
  EXPECT_THAT(why(Read("/styled/rig.a/vary", "s", "each")),
              HasSubstr("expected a whole number from 0 to 99"));
  EXPECT_THAT(why(Read("/styled/rig.a/style")), HasSubstr("expected a style and"));
  EXPECT_THAT(why(Read("/styled/rig.a/mix", "sfs", "a", 1.0, "b")), HasSubstr("in turn"));
  EXPECT_THAT(why(Read("/styled/rig.a/mix")), HasSubstr("in turn"));
  EXPECT_THAT(why(Read("/styled/rig.a/only", "s", "tail")), HasSubstr("parts of the body"));
  EXPECT_THAT(why(Read("/styled/rig.a/root", "s", "home")), HasSubstr("follow or stride"));
  EXPECT_THAT(why(Read("/styled/rig.a/dance")), HasSubstr("one of style, mix, strength"));
  EXPECT_THAT(why(Read("/styled/")), HasSubstr("one of style, mix, strength"));
  EXPECT_THAT(why(Read("/styled/cue")), HasSubstr("a cue's name"));
  EXPECT_THAT(why(Read("/VMC/Ext/OK", "i", 1)), HasSubstr("expected /styled/PERFORMER/style"));
  EXPECT_THAT(why(Read("/styled/rig.a/strength", "f", std::nan(""))), HasSubstr("a number"));
  // A request that is not UTF-8 could not be recorded, and no client could read its reply.
  EXPECT_THAT(why(Read("/styled/rig.a/style", "s", "\xFF")), HasSubstr("expected a style and"));
  EXPECT_THAT(why(Read("/styled/cue", "s", "\xC3")), HasSubstr("a cue's name"));
  EXPECT_THAT(why(Read("/styled/cue/\xFF")), HasSubstr("expected UTF-8"));
  EXPECT_THAT(why(Read("/styled/rig.\xE5/clear")), HasSubstr("expected UTF-8"));
}

}  // namespace
}  // namespace styled::control

// stylize with folders, several styles, standard input and output, as a user runs it.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "model/clip/any_clip.h"
#include "model/clip/clip.h"
#include "tests/e2e/tools.h"
#include "tests/unit/net/offset/weights.h"

namespace styled::support {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

// Styles: neutral, bent, raised.
class StylizeFiles : public ToolsTest {
 protected:
  StylizeFiles() {
    offset::WriteTestWeights(weights_);
    fs::create_directories(in_ + "/deep");
    const std::string walk = Walk("30", "1");
    for (const char* const name : {"a.bvh", "b.BVH", "deep/c.bvh", ".hidden.bvh"}) {
      fs::copy_file(walk, in_ + "/" + name);
    }
    WriteText(in_ + "/notes.txt", "no clip");
  }
  // Runs stylize in a shell with these words behind it, so that standard streams can be files;
  // output_ is its standard error, out_ its standard output.
  int Stylize(const std::string& words) {
    const std::string out = folder_ / "stdout";
    const int code =
        Run({"/bin/sh", "-c",
             std::string(STYLIZE_BINARY) + " --weights " + weights_ + " " + words + " >" + out});
    out_ = ReadText(out);
    return code;
  }
  std::vector<json> Lines() const {
    std::vector<json> lines;
    std::istringstream text(out_);
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
  }
  bool Exists(const std::string& file) const { return fs::exists(folder_ / file); }

  const std::string weights_ = folder_ / "weights", in_ = folder_ / "in", made_ = folder_ / "made";
  std::string out_;
};

TEST_F(StylizeFiles, WrongCommandLinesEndWithTwoAndWriteNothing) {
  const std::string a = in_ + "/a.bvh";
  for (const auto& [words, why] : std::vector<std::pair<std::string, std::string>>{
           {a, "expected an input and an output file"},
           {a + " " + a + " " + made_ + ".bvh",
            "found 3 files, expected an input and an output, or --out"},
           {"-s bent -o " + made_ + "/x.bvh " + in_, "found twice, for "},
           {"-s bent,raised -o '" + made_ + "/{name}.bvh' " + in_, "{style} in the output's name"},
           {"-s bent -o '" + made_ + "/{nome}.bvh' " + in_,
            "found {nome}, expected {name}, {dir} or"},
           {"-s bent -o '" + made_ + "/{name.bvh' " + in_, "found {name.bvh, expected"},
           {"-s bent -o '" + made_ + "/{name}.fbx' " + in_, "expected one of .bvh, .glb"},
           {"-s bent -o '" + made_ + "/{name}' " + in_, "found no extension"},
           {"-s bent -o - --json " + a, "--json excludes the standard output"},
           {"-s bent --format glb " + a + " " + made_ + ".bvh",
            "--format glb: expected the standard"},
           {"-s bent -o '" + made_ + "/{name}.bvh' - -", "the standard input twice"},
           {"-s '' " + a + " " + made_ + ".bvh", "--style: found nothing"},
           {"--rest lying " + a + " " + made_ + ".bvh",
            "'lying': expected auto, zero, standing"}}) {
    EXPECT_EQ(Stylize(words), 2) << words;
    EXPECT_THAT(output_, HasSubstr(why)) << words;
    EXPECT_EQ(out_, "");
  }
  EXPECT_EQ(Stylize("-s bent,zombie -o '" + made_ + "/{name}-{style}.bvh' " + in_), 2);
  EXPECT_THAT(output_, HasSubstr("unknown style 'zombie'"));
  EXPECT_EQ(Stylize("--joints leftHand " + a + " " + made_ + ".bvh"), 2);
  EXPECT_THAT(output_, HasSubstr("--joints: 'leftHand': expected CANONICAL=NAME"));
  EXPECT_FALSE(Exists("made")) << "before anything is written";
}

TEST_F(StylizeFiles, AFolderInSeveralStylesIsOneCommand) {
  ASSERT_EQ(Stylize("-s bent -s raised=0.5 -o '" + made_ + "/{style}/{name}.bvh' " + in_), 0)
      << output_;
  for (const char* const file : {"made/bent/a.bvh", "made/bent/b.bvh", "made/raised/a.bvh"}) {
    EXPECT_TRUE(Exists(file)) << file;
  }
  EXPECT_FALSE(Exists("made/bent/c.bvh")) << "a folder in it";
  EXPECT_FALSE(Exists("made/bent/.hidden.bvh"));
  EXPECT_THAT(out_, HasSubstr("a.bvh: 30 frames at 30 Hz, canonical, a foot stands in "));
  EXPECT_THAT(out_, HasSubstr("out of domain "));
  EXPECT_EQ(output_, "");
  // The same as one at a time.
  const std::string one = folder_ / "one.bvh";
  ASSERT_EQ(Stylize("-s bent " + in_ + "/a.bvh " + one), 0) << output_;
  EXPECT_EQ(ReadText(one), ReadText(made_ + "/bent/a.bvh"));
  EXPECT_NE(ReadText(one), ReadText(made_ + "/raised/a.bvh"));

  ASSERT_EQ(Stylize("-q -r -s bent,raised -o '" + made_ + "/{dir}/{name}-{style}.bvh' " + in_), 0)
      << output_;
  EXPECT_TRUE(Exists("made/deep/c-raised.bvh"));
  EXPECT_EQ(out_, "") << "quiet";
}

TEST_F(StylizeFiles, HowMuchOfTheStyleIsShownIsTold) {
  const std::string files = in_ + "/a.bvh " + made_ + ".bvh";
  ASSERT_EQ(Stylize("-s bent " + files), 0) << output_;
  EXPECT_THAT(out_, HasSubstr("joints turned by 0.8 degrees"));  // 0.3 rad of one joint in 21
  EXPECT_THAT(out_, Not(HasSubstr("hardly")));
  ASSERT_EQ(Stylize("--json -s bent --overwrite " + files), 0) << output_;
  const json line = Lines()[0];
  EXPECT_NEAR(line["turned_deg"].get<double>(), 0.82, 0.05);
  EXPECT_GT(line["moved_cm"]["hands"].get<double>(), 5);
  EXPECT_LT(line["moved_cm"]["feet"].get<double>(), 0.5);
  EXPECT_EQ(line["hardly_styled"], false);
  EXPECT_EQ(line["hardly_styled_s"], 0);
  EXPECT_NEAR(line["shown_share"]["trunk"].get<double>(), 1, 1e-3);
}

TEST_F(StylizeFiles, SecondsInWhichNothingIsToBeSeenAreTold) {
  auto offsets = offset::TestOffsets();
  offsets[1][body::kSpine] = body::Exp(body::Vec3(0.02F, 0, 0));
  ASSERT_TRUE(offset::Write(weights_, offset::TestModel(), offsets).ok());
  const std::string files = Walk("30", "2.5") + " " + made_ + ".bvh";
  ASSERT_EQ(Stylize("-s bent " + files), 0) << output_;
  EXPECT_THAT(out_, HasSubstr(", hardly styled for 3 of 3 s: the weights leave that"));
  ASSERT_EQ(Stylize("-s bent --strength 0.4 --overwrite " + files), 0) << output_;
  EXPECT_THAT(out_, Not(HasSubstr("hardly"))) << "not much was asked for";
  ASSERT_EQ(Stylize("--json -s bent --overwrite " + files), 0) << output_;
  EXPECT_EQ(Lines()[0]["hardly_styled"], true);
  EXPECT_EQ(Lines()[0]["hardly_styled_s"], 3);
}

TEST_F(StylizeFiles, ABadFileDoesNotStopTheOthers) {
  WriteText(in_ + "/aa.bvh", "HIERARCHY\n");
  EXPECT_EQ(
      Stylize("--json -s bent -o '" + made_ + "/{name}.bvh' " + in_ + " " + folder_ / "none.bvh"),
      1);
  EXPECT_TRUE(Exists("made/b.bvh")) << "it comes after aa.bvh";
  EXPECT_FALSE(Exists("made/aa.bvh"));
  EXPECT_THAT(output_, HasSubstr("aa.bvh:2: found the end, expected ROOT"));
  EXPECT_THAT(output_, HasSubstr("none.bvh: found no readable file"));
  EXPECT_THAT(output_, HasSubstr("2 of 4 outputs are written"));
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0]["written"], true);
  EXPECT_EQ(lines[0]["frames"], 30);
  EXPECT_EQ(lines[0]["style"], "bent");
  EXPECT_EQ(lines[0]["dialect"], "canonical");
  EXPECT_GT(lines[0]["feet"]["planted_share"], 0.3);
  EXPECT_GE(lines[0]["out_of_domain_share"], 0.0);
  EXPECT_EQ(lines[1]["written"], false);
  EXPECT_THAT(lines[1]["error"].get<std::string>(), HasSubstr("expected ROOT"));
  EXPECT_FALSE(lines[1].contains("frames"));

  const std::string empty = folder_ / "empty";
  fs::create_directory(empty);
  EXPECT_EQ(
      Stylize("-s bent --overwrite -o '" + made_ + "/{name}.bvh' " + empty + " " + in_ + "/a.bvh"),
      1);
  EXPECT_THAT(output_, HasSubstr("empty: found a folder without .bvh, .glb and .vrma files"));
  EXPECT_THAT(output_, HasSubstr("1 of 2 outputs"));
}

TEST_F(StylizeFiles, NothingIsReplacedWithoutLeave) {
  const std::string a = in_ + "/a.bvh", out = folder_ / "out.bvh";
  WriteText(out, "precious");
  EXPECT_EQ(Stylize("-s bent " + a + " " + out), 1);
  EXPECT_THAT(output_, HasSubstr("out.bvh: exists, expected a new file; --overwrite replaces it"));
  EXPECT_EQ(ReadText(out), "precious");
  EXPECT_EQ(Stylize("--overwrite -s bent " + a + " " + out), 0) << output_;
  EXPECT_NE(ReadText(out), "precious");
  for (const auto& entry : fs::directory_iterator(fs::path(out).parent_path())) {
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".stylize-"))) << "nothing is left";
  }
}

TEST_F(StylizeFiles, AnInputIsNeverReplacedWhateverItIsCalled) {
  const std::string a = in_ + "/a.bvh", before = ReadText(a);
  fs::create_symlink(a, folder_ / "soft.bvh");
  fs::create_hard_link(a, folder_ / "hard.bvh");
  fs::create_directory_symlink(in_, folder_ / "other");
  for (const std::string& out :
       {a, in_ + "/../in/a.bvh", std::string(folder_ / "soft.bvh"),
        std::string(folder_ / "hard.bvh"), std::string(folder_ / "other/a.bvh")}) {
    EXPECT_EQ(Stylize("--overwrite -s bent " + a + " " + out), 1) << out;
    EXPECT_THAT(output_, HasSubstr("is the input "));
    EXPECT_EQ(ReadText(a), before) << out;
  }
  // Of another input of the same run, too, and what is read besides.
  EXPECT_EQ(
      Stylize("--overwrite -q -s bent -o '" + in_ + "/{name}.bvh' " + in_ + " " + in_ + "/deep"),
      1);
  EXPECT_EQ(ReadText(a), before);
  EXPECT_THAT(output_, HasSubstr("2 of 3 outputs"));  // c.bvh and b.bvh are new in that folder
  const std::string avatar = folder_ / "avatar.bvh";
  fs::copy_file(a, avatar);
  EXPECT_EQ(Stylize("--overwrite -s bent --avatar " + avatar + " " + a + " " + avatar), 1);
  EXPECT_THAT(output_, HasSubstr("is the avatar "));
  EXPECT_EQ(ReadText(avatar), before);
}

TEST_F(StylizeFiles, ALinkToAnotherFileKeepsItsPlace) {
  WriteText(folder_ / "target.bvh", "old");
  fs::create_symlink(folder_ / "target.bvh", folder_ / "link.bvh");
  ASSERT_EQ(Stylize("--overwrite -s bent " + in_ + "/a.bvh " + (folder_ / "link.bvh")), 0)
      << output_;
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.bvh"));
  EXPECT_THAT(ReadText(folder_ / "target.bvh"), HasSubstr("MOTION"));
  fs::create_directory(folder_ / "folder.bvh");
  EXPECT_EQ(Stylize("--overwrite -s bent " + in_ + "/a.bvh " + (folder_ / "folder.bvh")), 1);
  EXPECT_THAT(output_, HasSubstr("is not an ordinary file"));
  fs::create_symlink("loop.bvh", folder_ / "loop.bvh");
  EXPECT_EQ(Stylize("--overwrite -s bent " + in_ + "/a.bvh " + (folder_ / "loop.bvh")), 1);
  EXPECT_THAT(output_, HasSubstr("loop.bvh: cannot be looked at"));
}

TEST_F(StylizeFiles, AStyleIsNamedOnce) {
  EXPECT_EQ(Stylize("-s bent=0.5,bent=1 -o '" + made_ + "/{name}-{style}.bvh' " + in_ + "/a.bvh"),
            2);
  EXPECT_THAT(output_, HasSubstr("--style: bent is named twice"));
}

TEST_F(StylizeFiles, StandardStreamsAreFilesToo) {
  const std::string a = in_ + "/a.bvh", out = folder_ / "out.bvh";
  ASSERT_EQ(Stylize("-s bent " + a + " " + out), 0) << output_;
  ASSERT_EQ(Stylize("-s bent - - <" + a), 0) << output_;
  EXPECT_EQ(out_, ReadText(out));
  EXPECT_THAT(output_, HasSubstr("- -> -: 30 frames")) << "the summary does not mix with the clip";
  ASSERT_EQ(Stylize("-q -s bent -o - --format glb " + a), 0) << output_;
  EXPECT_EQ(out_.substr(0, 4), "glTF");
  EXPECT_EQ(output_, "");
  ASSERT_EQ(Stylize("-s bent -o '" + made_ + "/{name}.bvh' - <" + a), 0) << output_;
  EXPECT_EQ(ReadText(made_ + "/stdin.bvh"), ReadText(out));
  EXPECT_EQ(Stylize("-s bent - - </dev/null"), 1);
  EXPECT_THAT(output_, HasSubstr("standard input:1: found the end"));
  EXPECT_EQ(out_, "");
}

TEST_F(StylizeFiles, JointsAreNamedByHand) {
  std::string text = ReadText(in_ + "/a.bvh");
  for (std::size_t at; (at = text.find("leftLowerLeg")) != std::string::npos;) {
    text.replace(at, 12, "wheel");
  }
  const std::string a = folder_ / "wheel.bvh", out = folder_ / "out.bvh";
  WriteText(a, text);
  EXPECT_EQ(Stylize("-s bent " + a + " " + out), 0) << "by the tree: " << output_;
  fs::remove(out);
  EXPECT_EQ(Stylize("-s bent --joints leftLowerLeg= " + a + " " + out), 1);
  EXPECT_THAT(output_, HasSubstr("found no joint named like leftLowerLeg"));
  EXPECT_THAT(output_, HasSubstr("its joints: hips, "));
  EXPECT_EQ(Stylize("-s bent --joints leftLowerLeg=wheel " + a + " " + out), 0) << output_;

  // Those of an avatar, which may have other names than the input.
  const std::string good = in_ + "/a.bvh",
                    to = " --overwrite --avatar " + a + " " + good + " " + out;
  EXPECT_EQ(Stylize("-s bent --avatar-joints leftLowerLeg=" + to), 1);
  EXPECT_THAT(output_, HasSubstr("--avatar " + a + ": "));
  EXPECT_THAT(output_, HasSubstr("found no joint named like leftLowerLeg"));
  EXPECT_EQ(Stylize("-s bent --avatar-joints leftLowerLeg=wheel" + to), 0) << output_;
  EXPECT_THAT(ReadText(out), HasSubstr("JOINT wheel"));
  EXPECT_EQ(Stylize("-s bent --avatar-joints leftLowerLeg=tyre" + to), 1);
  EXPECT_THAT(output_, HasSubstr("tyre"));
  EXPECT_EQ(Stylize("-s bent --avatar-joints wheel" + to), 2);
  EXPECT_THAT(output_, HasSubstr("--avatar-joints: 'wheel': expected CANONICAL=NAME"));
  EXPECT_EQ(Stylize("-s bent --avatar-joints leftLowerLeg=wheel " + good + " " + out), 2);
  EXPECT_THAT(output_, HasSubstr("--avatar-joints requires --avatar"));
}

TEST_F(StylizeFiles, SlidingIsThatOfStandingFeetNotOfASwing) {
  const std::string walk = Walk("60", "6"), glide = folder_ / "glide.bvh";
  clip::Clip clip = clip::ReadBvh(walk).value();
  float glided_cm = 0;
  for (rig::RigPose& frame : clip.frames) frame.translations[0].z() += glided_cm += 15.0F / 60;
  ASSERT_TRUE(clip::WriteBvh(clip, glide).ok());
  ASSERT_EQ(Stylize("--json -s bent -o '" + made_ + "/{name}.bvh' " + walk + " " + glide), 0)
      << output_;
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 2U);
  // The synthetic walk's feet stand still except for the last tenth of a second on the toes: 3.7,
  // by the judges' measure, too. With the feet that lift off, in contact for some 50 ms more, 18.6.
  EXPECT_LT(lines[0]["feet"]["input_slide_cm_s"], 6.0);
  EXPECT_LT(lines[0]["feet"]["slide_cm_s"], 8.0);
  // A floor of ice is not overlooked.
  EXPECT_GT(lines[1]["feet"]["input_slide_cm_s"], 12.0);
  EXPECT_LT(lines[1]["feet"]["input_slide_cm_s"], 20.0);
}

// The largest angle between joints of two clips, degrees, and distance of hips, cm, on the
// humanoid.
std::pair<float, float> Apart(const std::string& a, const std::string& b) {
  const auto poses = [](const std::string& file) {
    const auto clip = clip::ReadAnyClip(file);
    EXPECT_TRUE(clip.ok()) << clip.status().message();
    const auto bound = clip::BindAnyClip(clip.value());
    EXPECT_TRUE(bound.ok()) << bound.status().message();
    return clip::ToCanonical(clip.value().clip, bound.value().binding);
  };
  const auto first = poses(a), second = poses(b);
  EXPECT_EQ(first.size(), second.size());
  std::pair<float, float> most{0, 0};
  for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      const float angle_rad = first[i].rotations[j].angularDistance(second[i].rotations[j]);
      most.first = std::max(most.first, angle_rad * 57.29578F);
    }
    const float way_m = (first[i].hips_position_m - second[i].hips_position_m).norm();
    most.second = std::max(most.second, 100 * way_m);
  }
  return most;
}

TEST_F(StylizeFiles, ClipsInGltfAndVrmaAreStyledAsThoseInBvh) {
  const std::string a = in_ + "/a.bvh", to = folder_ / "to";
  fs::create_directory(to);
  ASSERT_EQ(Stylize("-q " + a + " " + to + "/glb.glb"), 0) << output_;
  ASSERT_EQ(Stylize("-q " + a + " " + to + "/vrma.vrma"), 0) << output_;
  ASSERT_EQ(Stylize("-q -s bent " + a + " " + made_ + "/bvh.bvh"), 0) << output_;
  ASSERT_EQ(Stylize("-s bent -o '" + made_ + "/{name}.bvh' " + to), 0) << output_;
  EXPECT_THAT(out_, HasSubstr("glb.bvh: 30 frames at 30 Hz, gltf, a foot stands"));
  EXPECT_THAT(out_, HasSubstr("vrma.bvh: 30 frames at 30 Hz, vrm, a foot stands"));
  ASSERT_EQ(Stylize("-q -s bent -o '" + made_ + "/{name}.vrma' " + to + " " + a), 0) << output_;
  ASSERT_EQ(Stylize("-q -s bent -o '" + made_ + "/{name}.glb' " + to), 0) << output_;
  const std::string bvh = made_ + "/bvh.bvh";
  EXPECT_GT(Apart(a, bvh).first, 10) << "the style is to be seen";
  for (const char* const other :
       {"glb.bvh", "vrma.bvh", "glb.vrma", "vrma.vrma", "a.vrma", "glb.glb", "vrma.glb"}) {
    const auto [degrees, centimetres] = Apart(bvh, made_ + "/" + other);
    EXPECT_LT(degrees, 0.5) << other;
    EXPECT_LT(centimetres, 0.5) << other;
  }
  ASSERT_EQ(Stylize("-q -s bent -o - --format bvh - <" + to + "/glb.glb"), 0) << output_;
  EXPECT_EQ(out_, ReadText(made_ + "/glb.bvh"));
  fs::remove(made_ + "/glb.bvh");
  EXPECT_EQ(Stylize("-s bent --rest standing " + to + "/glb.glb " + made_ + "/glb.bvh"), 1);
  EXPECT_THAT(output_, HasSubstr("glb.glb: found a rest pose or an up axis by hand"));
  WriteText(to + "/fbx.bvh", "Kaydara FBX Binary  ");
  EXPECT_EQ(Stylize("-s bent " + to + "/fbx.bvh " + made_ + "/fbx.bvh"), 1);
  EXPECT_THAT(output_, HasSubstr("fbx.bvh: found FBX, expected BVH, glTF binary (.glb) or VRMA"));
}

TEST_F(StylizeFiles, FeetThatSlideTwiceAsMuchAreAWarning) {
  const std::string files = Walk("60", "4") + " " + made_ + ".bvh";
  // The spine: the feet stay.
  ASSERT_EQ(Stylize("--json -s bent " + files), 0) << output_;
  EXPECT_FALSE(Lines()[0].contains("warning"));
  EXPECT_THAT(output_, Not(HasSubstr("warning")));
  // A knee that is lifted at every step, and nothing holds its foot.
  auto offsets = offset::TestOffsets();
  offsets[1][body::kLeftUpperLeg] = body::Exp(body::Vec3(-0.5F, 0, 0));
  offsets[1][body::kLeftLowerLeg] = body::Exp(body::Vec3(1.0F, 0, 0));
  ASSERT_TRUE(offset::Write(weights_, offset::TestModel(), offsets).ok());
  ASSERT_EQ(Stylize("--json --no-feet -s bent --overwrite " + files), 0) << output_;
  const json line = Lines()[0];
  const double slide = line["feet"]["slide_cm_s"], input = line["feet"]["input_slide_cm_s"];
  EXPECT_GT(slide, 2 * input);
  EXPECT_THAT(line["warning"].get<std::string>(), HasSubstr("standing feet slide "));
  EXPECT_THAT(line["warning"].get<std::string>(), Not(HasSubstr("stride")))
      << "these weights have no speeds";
  EXPECT_THAT(output_, HasSubstr(".bvh: warning: standing feet slide "));
}

TEST_F(StylizeFiles, APreviewIsAPictureOrAFilm) {
  const std::string a = in_ + "/a.bvh";
  ASSERT_EQ(Stylize("-s bent,raised -o '" + made_ + "/{style}.bvh' --preview '" + made_ +
                    "/{style}.png' " + a),
            0)
      << output_;
  EXPECT_EQ(ReadText(made_ + "/raised.png").substr(1, 3), "PNG");
  EXPECT_NE(ReadText(made_ + "/raised.png"), ReadText(made_ + "/bent.png"));
  EXPECT_EQ(Stylize("-s bent --preview x.gif " + a + " " + made_ + ".bvh"), 2);
  EXPECT_THAT(output_, HasSubstr("--preview x.gif: expected .png or .mp4"));

  // A film is ffmpeg's work; here one that counts the bytes of its pictures.
  const auto film = [&](const std::string& search) {
    return Run({"/usr/bin/env", "PATH=" + search, STYLIZE_BINARY, "--weights", weights_, "-s",
                "bent", "--overwrite", "--preview", folder_ / "film.mp4", a, folder_ / "out.bvh"});
  };
  EXPECT_EQ(film(folder_ / "bin"), 1);
  EXPECT_THAT(output_, HasSubstr("found no program ffmpeg in PATH"));
  EXPECT_FALSE(Exists("out.bvh")) << "it is said before the work";
  fs::create_directory(folder_ / "bin");
  WriteText(folder_ / "bin/ffmpeg", "#!/bin/sh\nfor file; do :; done\nwc -c >\"$file\"\n");
  fs::permissions(folder_ / "bin/ffmpeg", fs::perms::owner_all);
  EXPECT_EQ(film(folder_ / "bin:/bin:/usr/bin"), 0) << output_;
  EXPECT_EQ(std::stoul(ReadText(folder_ / "film.mp4")), 30UL * 640 * 400 * 3);
  WriteText(folder_ / "bin/ffmpeg", "#!/bin/sh\nexit 1\n");
  EXPECT_EQ(film(folder_ / "bin:/bin:/usr/bin"), 1);
  EXPECT_THAT(output_, HasSubstr("film.mp4: ffmpeg did not write it"));
}

}  // namespace
}  // namespace styled::support

// Writes bodies of every naming convention, and random ones, as seeds of binder_fuzz.
#include "tests/fuzz/binder/skeleton_bytes.h"
#include "tests/fuzz/write_seeds.h"
#include "tests/unit/rig/random_bodies.h"

int main(int argc, char** argv) {
  using namespace styled;
  std::vector<std::vector<std::byte>> seeds;
  for (unsigned seed = 0; seed < 80; ++seed) {
    clip::Clip clip;
    clip.skeleton = rig::MakeRandomBody(seed).skeleton;
    if (clip.skeleton.joint_count() > 255) continue;
    clip.frames.assign(2, rig::RigPose(clip.skeleton));
    seeds.push_back(fuzz::WriteClip(clip));
  }
  return fuzz::WriteSeeds(argc, argv, seeds);
}

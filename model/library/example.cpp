// A BVH file is restyled as a whole, and once more frame by frame: c++ -std=c++20 example.cpp
// -lstyled; ./a.out walk.bvh STYLE out.bvh
#include <cstdio>
#include <exception>
#include <styled.hpp>

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s IN.bvh STYLE OUT.bvh\n", argv[0]), 2;
  try {
    const styled::library::Network network;
    auto clip = styled::library::Clip::Read(argv[1]);
    std::vector<float> root, rotations;
    clip.Frames(root, rotations);
    styled::library::Performer performer(network, clip.body());
    performer.Learn(clip);
    const styled::library::Weighted style{network.Find(argv[2])};
    performer.Set({&style, 1});
    const std::size_t joints = rotations.size() / clip.frames() / 4;
    for (std::size_t frame = 0; frame < clip.frames(); ++frame) {
      const std::span at(&root[3 * frame], 3), turns(&rotations[4 * joints * frame], 4 * joints);
      performer.Frame(static_cast<std::int64_t>(1e9 * double(frame) / clip.rate_hz()), at, turns,
                      at, turns);
    }
    std::printf("live: the last frame's hips at %.3f %.3f %.3f\n", root.end()[-3], root.end()[-2],
                root.end()[-1]);
    clip.Restyle(network, argv[2]);
    clip.Write(argv[3]);
    std::printf("%s: %zu frames, %s\n", argv[3], clip.frames(),
                network.Licence(style.style).c_str());
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}

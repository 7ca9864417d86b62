#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/train/baselines/baseline.h"

namespace styled::train::baselines {
namespace {

using stgcn::kFeatureCount;
using torch::Tensor;

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A frame is compared with others by itself and the frames 2 and 4 before, five frames as in the
// paper, in this number of principal axes.
constexpr int kLags[] = {0, 2, 4};
constexpr int kAxes = 32;
constexpr int kEvery = 2;       // frames between those that are kept: neighbours in time are alike
constexpr int kNeighbours = 8;  // whose differences are averaged
// Share of the difference that a frame takes over from the frame before, instead of the paper's
// autoregression: 0.1 s at 30 Hz.
constexpr float kKeep = 0.72F;

// Every frame of a clip with its predecessors, [T, 3 * 147]; before the first frame it is repeated.
Rows WithPast(const Rows& frames) {
  Rows out(frames.rows(), static_cast<long>(std::size(kLags)) * kFeatureCount);
  for (long t = 0; t < frames.rows(); ++t) {
    long column = 0;
    for (const int lag : kLags) {
      out.block(t, column, 1, kFeatureCount) = frames.row(std::max<long>(0, t - lag));
      column += kFeatureCount;
    }
  }
  return out;
}

// The frames of a style, and of each its content.
struct Frames {
  std::vector<float> poses;  // [n, 147]
  std::vector<float> pasts;  // [n, 441]
  std::vector<int> contents;
  long count() const { return static_cast<long>(contents.size()); }
  Eigen::Map<const Rows> Poses() const { return {poses.data(), count(), kFeatureCount}; }
  Eigen::Map<const Rows> Pasts() const {
    return {pasts.data(), count(), static_cast<long>(std::size(kLags)) * kFeatureCount};
  }
};

// The row of `among` that is nearest to `wanted`.
long Nearest(const Rows& among, const Eigen::RowVectorXf& wanted) {
  long nearest = 0;
  (among.rowwise() - wanted).rowwise().squaredNorm().minCoeff(&nearest);
  return nearest;
}

class Neighbours final : public Baseline {
 public:
  explicit Neighbours(const Material& material) : Baseline(material, 1) {}

  Tensor CodeOf(const Tensor&) const override { return torch::zeros({1}); }
  net::StyleCode MakeCode(const net::StyleRequest& request) const override;
  net::NearestStyle Nearest(const net::StyleCode& code) const override;
  Tensor Styled(const Tensor& clip, const Tensor& code) const override;
  Tensor Own(const Tensor& clip) const override { return clip; }

 protected:
  torch::nn::Module& networks() override { return none_; }
  void Train(const Budget&) override {}
  void Prepare() override;

 private:
  void FitAxes(const Rows& pasts);
  Rows Project(const Rows& pasts) const { return (pasts.rowwise() - mean_) * axes_; }
  std::size_t StyleOf(std::span<const body::Pose> example) const;
  Frames Collect(int style) const;
  Rows MeansByContent(const Frames& frames, const Rows& projected) const;

  mutable torch::nn::Module none_;
  Eigen::RowVectorXf mean_;
  Rows axes_;                      // [441, kAxes]
  Rows neutral_;                   // [n, kAxes]
  std::vector<Rows> differences_;  // by style: of each neutral frame to its like in the style
  std::vector<Eigen::RowVectorXf> poses_;  // by style: the mean pose
};

Frames Neighbours::Collect(int style) const {
  Frames all;
  for (int clip = 0; clip < material_.store.clips(); ++clip) {
    if (material_.store.StyleOf(clip) != style) continue;
    const Tensor frames = material_.store.FramesOf(clip).contiguous();
    const Rows poses =
        Eigen::Map<const Rows>(frames.data_ptr<float>(), frames.size(0), kFeatureCount);
    const Rows pasts = WithPast(poses);
    for (long t = 0; t < poses.rows(); t += kEvery) {
      all.poses.insert(all.poses.end(), poses.row(t).begin(), poses.row(t).end());
      all.pasts.insert(all.pasts.end(), pasts.row(t).begin(), pasts.row(t).end());
      all.contents.push_back(material_.store.ContentOf(clip, static_cast<int>(t)));
    }
  }
  return all;
}

Rows Neighbours::MeansByContent(const Frames& frames, const Rows& projected) const {
  Rows means = Rows::Zero(material_.contents, projected.cols());
  std::vector<float> counts(static_cast<std::size_t>(material_.contents), 0);
  for (long i = 0; i < frames.count(); ++i) {
    const int content = frames.contents[static_cast<std::size_t>(i)];
    means.row(content) += projected.row(i);
    counts[static_cast<std::size_t>(content)] += 1;
  }
  for (int content = 0; content < material_.contents; ++content) {
    means.row(content) /= std::max(1.0F, counts[static_cast<std::size_t>(content)]);
  }
  return means;
}

void Neighbours::FitAxes(const Rows& pasts) {
  mean_ = pasts.colwise().mean();
  const Rows centred = pasts.rowwise() - mean_;
  const Eigen::MatrixXf covariance = centred.transpose() * centred;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(covariance);
  axes_ = solver.eigenvectors().rightCols(kAxes);
}

// The like of a neutral frame in a style is the nearest one of the same content, after each
// style's mean in that content is taken off: the clips are not aligned in time. Where the style
// has no such content, the nearest of any.
void Neighbours::Prepare() {
  const Frames neutral = Collect(0);
  FitAxes(neutral.Pasts());
  neutral_ = Project(neutral.Pasts());
  const Rows neutral_means = MeansByContent(neutral, neutral_);
  differences_.assign(1, Rows::Zero(neutral.count(), kFeatureCount));
  poses_.assign(1, neutral.Poses().colwise().mean());
  for (int style = 1; style < static_cast<int>(model().styles.size()); ++style) {
    const Frames styled = Collect(style);
    Rows projected = Project(styled.Pasts());
    const Rows means = MeansByContent(styled, projected);
    std::vector<std::vector<long>> places(static_cast<std::size_t>(material_.contents));
    for (long i = 0; i < styled.count(); ++i) {
      const int content = styled.contents[static_cast<std::size_t>(i)];
      places[static_cast<std::size_t>(content)].push_back(i);
      projected.row(i) -= means.row(content);
    }
    std::vector<long> all(static_cast<std::size_t>(styled.count()));
    std::iota(all.begin(), all.end(), 0L);
    std::vector<Rows> of_content;
    for (const std::vector<long>& some : places) {
      of_content.push_back(projected(some.empty() ? all : some, Eigen::all));
    }
    Rows differences(neutral.count(), kFeatureCount);
    for (long i = 0; i < neutral.count(); ++i) {
      const auto content = static_cast<std::size_t>(neutral.contents[static_cast<std::size_t>(i)]);
      const std::vector<long>& from = places[content].empty() ? all : places[content];
      const Eigen::RowVectorXf wanted =
          neutral_.row(i) - neutral_means.row(static_cast<long>(content));
      const long like =
          from[static_cast<std::size_t>(baselines::Nearest(of_content[content], wanted))];
      differences.row(i) = styled.Poses().row(like) - neutral.Poses().row(i);
    }
    differences_.push_back(std::move(differences));
    poses_.emplace_back(styled.Poses().colwise().mean());
  }
}

// The weight of each style: the method needs clips of it, so an example counts as its style, and
// one without a label as the style whose mean pose is nearest.
net::StyleCode Neighbours::MakeCode(const net::StyleRequest& request) const {
  net::StyleCode code(model().styles.size(), 0.0F);
  for (const net::StyleSource& source : request.sources) {
    const std::size_t style =
        source.style < 0 ? StyleOf(source.reference) : static_cast<std::size_t>(source.style);
    code[style] += request.strength * source.weight;
  }
  return code;
}

std::size_t Neighbours::StyleOf(std::span<const body::Pose> example) const {
  const Tensor clip = Read(example, nullptr).mean(1).contiguous();
  const Eigen::Map<const Eigen::RowVectorXf> pose(clip.data_ptr<float>(), kFeatureCount);
  const auto nearer = [&pose](const auto& a, const auto& b) {
    return (a - pose).squaredNorm() < (b - pose).squaredNorm();
  };
  return static_cast<std::size_t>(std::min_element(poses_.begin(), poses_.end(), nearer) -
                                  poses_.begin());
}

net::NearestStyle Neighbours::Nearest(const net::StyleCode& code) const {
  const auto largest = std::max_element(code.begin(), code.end());
  return {static_cast<int>(largest - code.begin()), 0};
}

Tensor Neighbours::Styled(const Tensor& clip, const Tensor& code) const {
  const Tensor rows = clip.t().contiguous();
  const Rows frames = Eigen::Map<const Rows>(rows.data_ptr<float>(), rows.size(0), kFeatureCount);
  const Rows wanted = Project(WithPast(frames));
  Eigen::RowVectorXf difference;
  Rows out = frames;
  std::vector<int> order(static_cast<std::size_t>(neutral_.rows()));
  for (long t = 0; t < frames.rows(); ++t) {
    const Eigen::VectorXf distance = (neutral_.rowwise() - wanted.row(t)).rowwise().squaredNorm();
    std::iota(order.begin(), order.end(), 0);
    const auto end = order.begin() + std::min<long>(kNeighbours, neutral_.rows());
    std::partial_sort(order.begin(), end, order.end(),
                      [&distance](int a, int b) { return distance[a] < distance[b]; });
    // Weights fall with the distance, whose scale is that of the farthest of them.
    const float scale = std::max(1e-6F, distance[*(end - 1)]);
    Eigen::RowVectorXf now = Eigen::RowVectorXf::Zero(kFeatureCount);
    float sum = 0;
    for (auto i = order.begin(); i != end; ++i) {
      const float weight = std::exp(-distance[*i] / scale);
      sum += weight;
      for (std::size_t style = 1; style < differences_.size(); ++style) {
        const float of_style = code[static_cast<int64_t>(style)].item<float>();
        if (of_style != 0) now += weight * of_style * differences_[style].row(*i);
      }
    }
    now /= sum;
    difference = t == 0 ? now : Eigen::RowVectorXf(kKeep * difference + (1 - kKeep) * now);
    out.row(t) += difference;
  }
  return torch::from_blob(out.data(), {out.rows(), out.cols()}).clone().t();
}

}  // namespace

std::unique_ptr<Baseline> MakeNeighbours(const Material& material) {
  return std::make_unique<Neighbours>(material);
}

}  // namespace styled::train::baselines

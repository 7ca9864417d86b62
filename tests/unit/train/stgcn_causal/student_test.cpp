// The student against its equations (model/net/stgcn_causal/FORMAT.md), in a plain loop over frames
// with one matrix per frame: a column per node.

#include "model/train/stgcn_causal/student.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "model/train/stgcn_causal/learner.h"

namespace styled::train::st_gcn_causal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using torch::Tensor;

constexpr int kFrames = 40;

double Largest(const Tensor& a, const Tensor& b) { return (a - b).abs().max().item<double>(); }

MatrixXd ToEigen(const Tensor& tensor) {  // of one or two dimensions
  const Tensor rows = tensor.detach().dim() == 1 ? tensor.detach().unsqueeze(1) : tensor.detach();
  MatrixXd out(rows.size(0), rows.size(1));
  for (int i = 0; i < out.rows(); ++i) {
    for (int j = 0; j < out.cols(); ++j) out(i, j) = rows[i][j].item<double>();
  }
  return out;
}

MatrixXd Relu(const MatrixXd& x) { return x.cwiseMax(0); }
MatrixXd Leaky(const MatrixXd& x) { return x.cwiseMax(0.2 * x); }

class PlainStudent {
 public:
  explicit PlainStudent(const Parameters& parameters) {
    for (const auto& [name, tensor] : parameters.named()) {
      if (tensor.dim() < 3) weights_[name] = ToEigen(tensor);
      for (int64_t tap = 0; tensor.dim() == 3 && tap < 3; ++tap) {
        weights_[name + std::to_string(tap)] = ToEigen(tensor.select(2, tap));
      }
    }
  }

  // One frame: [7, 21] in and out.
  MatrixXd Step(const MatrixXd& features, const VectorXd& code) {
    const MatrixXd clamped = features.cwiseMax(-4).cwiseMin(4);
    MatrixXd x = W("g.in.weight") * clamped;
    x.colwise() += W("g.in.bias").col(0);
    x += W("g.in.node_bias").transpose();
    x = Encode("g.enc2", 1, 4, Encode("g.enc1", 0, 2, x));
    x = Decode("g.dec2", 1, 1, code, Decode("g.dec1", 2, 2, code, x));
    x = (W("g.out.weight") * x).eval();
    x.colwise() += W("g.out.bias").col(0);
    x(0, 0) = x(2, 0) = 0;
    return x;
  }

 private:
  struct Sums {
    VectorXd sum, square;
    double count = 16;
  };

  const MatrixXd& W(const std::string& name) const { return weights_.at(name); }

  MatrixXd Normalized(const std::string& name, const MatrixXd& x) {
    Sums& sums = sums_[name];
    if (sums.sum.size() == 0) {
      sums.sum = 16 * W(name + ".start_mean");
      sums.square = 16 * W(name + ".start_square");
    }
    const double keep = 20.0 / 21.0;
    sums.count = keep * sums.count + 1;
    sums.sum = keep * sums.sum + x.rowwise().mean();
    sums.square = keep * sums.square + x.array().square().matrix().rowwise().mean();
    const VectorXd mean = sums.sum / sums.count;
    const VectorXd variance =
        (sums.square / sums.count - mean.array().square().matrix()).cwiseMax(0);
    const VectorXd inverse = (variance.array() + 1e-5).rsqrt();
    return inverse.asDiagonal() * (x.colwise() - mean);
  }

  MatrixXd Norm(const std::string& name, const MatrixXd& x) {
    const VectorXd scale = W(name + ".scale");
    return (scale.asDiagonal() * Normalized(name, x)).colwise() + W(name + ".shift").col(0);
  }

  MatrixXd Adain(const std::string& name, const MatrixXd& x, const VectorXd& code) {
    const VectorXd both = W(name + ".weight") * code + W(name + ".bias");
    const VectorXd scale = both.head(x.rows()).array() + 1;
    return (scale.asDiagonal() * Normalized(name, x)).colwise() + both.tail(x.rows());
  }

  MatrixXd Convolve(const std::string& name, int level, const MatrixXd& x) const {
    const MatrixXd& weight = W(name + ".weight");
    const Eigen::Index out = weight.rows() / stgcn::kLabelCount;
    MatrixXd y = W(name + ".node_bias").transpose();
    const auto adjacency = stgcn::Adjacency(level);
    for (int k = 0; k < stgcn::kLabelCount; ++k) {
      MatrixXd inner = weight.middleRows(k * out, out) * x;
      inner.colwise() += W(name + ".bias").col(0).segment(k * out, out);
      y += inner * adjacency[static_cast<std::size_t>(k)].cast<double>();
    }
    return y;
  }

  // Keeps all that the convolution has seen.
  MatrixXd OverTime(const std::string& name, int spacing, const MatrixXd& x) {
    std::vector<MatrixXd>& seen = seen_[name];
    seen.push_back(x);
    MatrixXd y = W(name + ".bias").replicate(1, x.cols());
    for (int tap = 0; tap < 3; ++tap) {
      const int at = static_cast<int>(seen.size()) - 1 - (2 - tap) * spacing;
      y += W(name + ".weight" + std::to_string(tap)) *
           seen[static_cast<std::size_t>(std::max(at, 0))];
    }
    return y;
  }

  MatrixXd Encode(const std::string& name, int level, int spacing, const MatrixXd& x) {
    const MatrixXd pool = stgcn::Pooling(level).cast<double>();
    MatrixXd y = Convolve(name + ".gconv1", level, Leaky(Norm(name + ".norm1", x))) * pool;
    y = OverTime(name + ".tconv1", spacing, Relu(y));
    y = Convolve(name + ".gconv2", level + 1, Leaky(Norm(name + ".norm2", y)));
    y = OverTime(name + ".tconv2", spacing, Relu(y));
    return (W(name + ".skip.weight") * x * pool + y) / std::sqrt(2.0);
  }

  MatrixXd Decode(const std::string& name, int level, int spacing, const VectorXd& code,
                  const MatrixXd& x) {
    const MatrixXd unpool = stgcn::Unpooling(level - 1).cast<double>();
    MatrixXd y =
        Convolve(name + ".gconv1", level, Leaky(Adain(name + ".adain1", x, code))) * unpool;
    y = OverTime(name + ".tconv1", spacing, Relu(y));
    y = Convolve(name + ".gconv2", level - 1, Leaky(Adain(name + ".adain2", y, code)));
    y = OverTime(name + ".tconv2", spacing, Relu(y));
    return (W(name + ".skip.weight") * x * unpool + y) / std::sqrt(2.0);
  }

  std::map<std::string, MatrixXd> weights_;
  std::map<std::string, Sums> sums_;
  std::map<std::string, std::vector<MatrixXd>> seen_;
};

class StudentTest : public testing::Test {
 protected:
  StudentTest() : student_(Shape(), torch::kCPU) {
    torch::manual_seed(2);
    for (const auto& [name, tensor] : student_.parameters.named()) {
      const auto inputs = static_cast<double>(tensor.dim() > 1 ? tensor[0].numel() : 100);
      tensor.normal_(0, std::sqrt(2 / inputs));
      if (name.ends_with(".scale") || name.ends_with(".start_square")) tensor.add_(1);
    }
  }
  static st_gcn::Shape Shape() {
    st_gcn::Shape shape;
    shape.width = 8;
    shape.code = 6;
    return shape;
  }

  const torch::NoGradGuard no_grad_;
  Student student_;
};

TEST_F(StudentTest, IsItsEquationsFrameByFrame) {
  const Graph graph(torch::kCPU, torch::kFloat32, kFrames);
  // A walk of random steps: correlated frames, and some features beyond the limit.
  const Tensor x = 0.4 * torch::randn({2, kFrames, 21, 7}).cumsum(1);
  EXPECT_GT(x.abs().max().item<double>(), 5);
  const Tensor code = torch::randn({2, 6});
  const Tensor y = student_.Decode(graph, student_.Encode(graph, x), code);
  ASSERT_EQ(y.sizes(), x.sizes());
  for (int64_t sample = 0; sample < 2; ++sample) {
    PlainStudent plain(student_.parameters);
    for (int64_t t = 0; t < kFrames; ++t) {
      const MatrixXd expected = plain.Step(ToEigen(x[sample][t].t()), ToEigen(code[sample]).col(0));
      const MatrixXd difference = ToEigen(y[sample][t].t()) - expected;
      EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-4) << sample << ' ' << t;
    }
  }
  EXPECT_GT(y.std().item<double>(), 0.1) << "the control: it is about something";
}

TEST_F(StudentTest, InBfloat16ItIsNearlyTheSame) {
  const Graph exact(torch::kCPU, torch::kFloat32, kFrames);
  const Graph coarse(torch::kCPU, torch::kBFloat16, kFrames);
  const Tensor x = torch::randn({2, kFrames, 21, 7}), code = torch::randn({2, 6});
  const Tensor y = student_.Decode(exact, student_.Encode(exact, x), code);
  const Tensor z = student_.Decode(coarse, student_.Encode(coarse, x), code);
  EXPECT_EQ(z.scalar_type(), torch::kFloat32);
  EXPECT_LT((y - z).abs().mean().item<double>(), 0.03 * y.abs().mean().item<double>());
}

TEST_F(StudentTest, TakesOverTheTeachersWeightsAndKeepsItsStarts) {
  st_gcn::Generator teacher(Shape(), torch::kCPU);
  const Tensor start = student_.parameters.Find("g.dec1.adain2.start_mean").clone();
  student_.CopyFrom(teacher);
  EXPECT_TRUE(torch::equal(student_.parameters.Find("g.enc2.tconv1.weight"),
                           teacher.parameters.Find("g.enc2.tconv1.weight")));
  EXPECT_TRUE(torch::equal(student_.parameters.Find("g.dec1.adain2.start_mean"), start));
  // Two numbers per channel and norm more: 8, 8; 16, 16; 32, 16; 16, 8.
  EXPECT_EQ(student_.parameters.flat().numel(), teacher.parameters.flat().numel() + 2 * 120);
}

// Observed norms start with the moments of what they saw; without windows they start as before.
TEST_F(StudentTest, TheStartOfTheStatisticsIsMeasured) {
  const Graph graph(torch::kCPU, torch::kFloat32, kFrames);
  const Tensor before = student_.parameters.Find("g.enc1.norm1.start_mean").clone();
  const auto observe = [this](bool on) {
    for (PastNorm* norm : student_.norms()) norm->Observe(on);
  };
  observe(true);
  observe(false);
  EXPECT_TRUE(torch::equal(before, student_.parameters.Find("g.enc1.norm1.start_mean")));

  const Tensor x = 0.5 + torch::randn({6, kFrames, 21, 7}), code = torch::randn({6, 6});
  observe(true);
  for (int64_t i = 0; i < 6; i += 2) {
    student_.Decode(graph, student_.Encode(graph, x.narrow(0, i, 2)), code.narrow(0, i, 2));
  }
  observe(false);
  const Tensor in = at::linear(x.clamp(-4, 4), student_.parameters.Find("g.in.weight"),
                               student_.parameters.Find("g.in.bias")) +
                    student_.parameters.Find("g.in.node_bias");
  EXPECT_LT(Largest(in.flatten(0, 2).mean(0), student_.parameters.Find("g.enc1.norm1.start_mean")),
            1e-5);
  EXPECT_LT(Largest(in.square().flatten(0, 2).mean(0),
                    student_.parameters.Find("g.enc1.norm1.start_square")),
            1e-4);
  // All of them moved, the decoder's too.
  for (PastNorm* norm : student_.norms()) {
    EXPECT_GE((norm->start_square - norm->start_mean.square()).min().item<double>(), -1e-5);
  }
  const Tensor last = student_.parameters.Find("g.dec2.adain2.start_mean").clone();
  student_.Decode(graph, student_.Encode(graph, x), code);
  EXPECT_TRUE(torch::equal(last, student_.parameters.Find("g.dec2.adain2.start_mean")))
      << "nothing is observed afterwards";
}

TEST(WeightedL1Test, TheFirstFramesCountLess) {
  const Tensor first = torch::zeros({1, 16, 21, 7}), last = torch::zeros({1, 16, 21, 7});
  first.narrow(1, 0, 8).fill_(-3);
  last.narrow(1, 8, 8).fill_(3);
  EXPECT_NEAR(WeightedL1(first, 0.5).item<double>(), 1, 1e-6);
  EXPECT_NEAR(WeightedL1(last, 0.5).item<double>(), 2, 1e-6);
  EXPECT_NEAR(WeightedL1(first, 1).item<double>(), 1.5, 1e-6);
  EXPECT_NEAR(WeightedL1(first, 0).item<double>(), 0, 1e-6);
}

}  // namespace
}  // namespace styled::train::st_gcn_causal

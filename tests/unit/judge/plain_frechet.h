#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace styled::judge {

// The Frechet distance of Gaussians and principal axes with an eigen-decomposition of their own, to
// compare FMD with.

// Eigenvalues and eigenvectors (columns) of a symmetric matrix by Jacobi's rotations.
struct Jacobi {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;

  explicit Jacobi(Eigen::MatrixXd a) : vectors(Eigen::MatrixXd::Identity(a.rows(), a.rows())) {
    const Eigen::Index n = a.rows();
    for (int sweep = 0; sweep < 30; ++sweep) {
      for (Eigen::Index p = 0; p < n; ++p) {
        for (Eigen::Index q = p + 1; q < n; ++q) {
          if (std::abs(a(p, q)) < 1e-300) continue;
          const double angle = 0.5 * std::atan2(2 * a(p, q), a(q, q) - a(p, p));
          const double c = std::cos(angle), s = std::sin(angle);
          const auto turn = [&](auto x, auto y) {
            const Eigen::VectorXd was = x;
            x = c * was - s * Eigen::VectorXd(y);
            y = s * was + c * Eigen::VectorXd(y);
          };
          turn(a.col(p), a.col(q));
          turn(a.row(p).transpose(), a.row(q).transpose());
          turn(vectors.col(p), vectors.col(q));
        }
      }
    }
    values = a.diagonal();
  }
};

inline Eigen::MatrixXd PlainCovariance(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(x.cols(), x.cols());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Eigen::VectorXd apart = (x.row(i) - x.colwise().mean()).transpose();
    sum += apart * apart.transpose();
  }
  return sum / static_cast<double>(x.rows() - 1);
}

// |μa - μb|² + tr(A + B - 2 (√A B √A)^½).
inline double PlainFrechet(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::MatrixXd of_a = PlainCovariance(a), of_b = PlainCovariance(b);
  const Jacobi eigen(of_a);
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(of_a.rows(), of_a.cols());
  for (Eigen::Index i = 0; i < root.rows(); ++i) {
    root += std::sqrt(std::max(0.0, eigen.values[i])) * eigen.vectors.col(i) *
            eigen.vectors.col(i).transpose();
  }
  const Jacobi product(root * of_b * root);
  double distance = (a.colwise().mean() - b.colwise().mean()).squaredNorm();
  for (Eigen::Index i = 0; i < root.rows(); ++i) {
    distance += of_a(i, i) + of_b(i, i) - 2 * std::sqrt(std::max(0.0, product.values[i]));
  }
  return distance;
}

// The `count` principal axes (columns) of fewer samples than columns, from their products.
inline Eigen::MatrixXd PlainAxes(const Eigen::MatrixXd& samples, Eigen::Index count) {
  const Eigen::MatrixXd centred = samples.rowwise() - samples.colwise().mean();
  const Jacobi products(centred * centred.transpose());
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](Eigen::Index x, Eigen::Index y) {
    return products.values[x] > products.values[y];
  });
  Eigen::MatrixXd axes(samples.cols(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    axes.col(i) = (centred.transpose() * products.vectors.col(order[static_cast<std::size_t>(i)]))
                      .normalized();
  }
  return axes;
}

}  // namespace styled::judge

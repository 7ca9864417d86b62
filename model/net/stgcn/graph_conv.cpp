#include "model/net/stgcn/graph_conv.h"

#include <algorithm>
#include <cassert>

#include "model/net/stgcn/size.h"

namespace styled::stgcn {
namespace {

using net::RowMajor;
using net::RowMixture;
using net::RowTerm;

void Pack(const Eigen::Ref<const RowMajor>& from, std::size_t term, net::PackedColumns& to) {
  for (int column = 0; column < from.rows(); ++column) {
    for (int channel = 0; channel < from.cols(); ++channel) {
      to.At(term, column, channel) = from(column, channel);
    }
  }
}

bool HasEntries(const Eigen::MatrixXf& matrix, Eigen::Index row) {
  return (matrix.row(row).array() != 0).any();
}

int CountRows(const Eigen::MatrixXf& matrix) {
  return static_cast<int>((matrix.array() != 0).rowwise().any().count());
}

}  // namespace

GraphConv::GraphConv(const std::array<Eigen::MatrixXf, kLabelCount>& mixing, const RowMajor& weight,
                     const Eigen::VectorXf& bias, const RowMajor& node_bias)
    : in_nodes_(static_cast<int>(mixing[0].rows())),
      out_nodes_(static_cast<int>(mixing[0].cols())),
      in_channels_(static_cast<int>(weight.cols())),
      out_channels_(static_cast<int>(weight.rows()) / kLabelCount),
      constant_(static_cast<std::size_t>(out_nodes_ * out_channels_)) {
  assert(in_channels_ % net::kRowPanel == 0 && out_channels_ % net::kRowPanel == 0);
  Eigen::Map<RowMajor> constant(constant_.data(), out_nodes_, out_channels_);
  constant = node_bias;
  together_ = true;
  for (std::size_t k = 0; k < kLabelCount; ++k) {
    const Eigen::Index begin = static_cast<Eigen::Index>(k) * out_channels_;
    constant +=
        mixing[k].colwise().sum().transpose() * bias.segment(begin, out_channels_).transpose();
    PackLabel(mixing[k], weight.middleRows(begin, out_channels_), labels_[k]);
    together_ = together_ && labels_[k].is_mixed && labels_[k].rows == out_nodes_;
  }
  if (!together_) {
    LinkOutput(mixing);
    return;
  }
  const std::array<int, kLabelCount> depths{in_channels_, in_channels_, in_channels_};
  all_ = net::PackedColumns(depths, out_channels_);
  for (std::size_t k = 0; k < kLabelCount; ++k) {
    Pack(weight.middleRows(static_cast<Eigen::Index>(k) * out_channels_, out_channels_), k, all_);
    labels_[k].weight = {};
  }
}

// Decides where the label is mixed, and lists the rows of its product.
void GraphConv::PackLabel(const Eigen::MatrixXf& mixing, const Eigen::Ref<const RowMajor>& weight,
                          OneLabel& label) {
  const int sources = CountRows(mixing), targets = CountRows(mixing.transpose());
  label.is_mixed = targets < sources;
  label.rows = std::min(targets, sources);
  const std::array<int, 1> depth{in_channels_};
  label.weight = net::PackedColumns(depth, out_channels_);
  Pack(weight, 0, label.weight);
  if (!label.is_mixed && sources == in_nodes_) return;  // x as it is
  const Eigen::MatrixXf rows = label.is_mixed ? Eigen::MatrixXf(mixing.transpose()) : mixing;
  for (int row = 0; row < rows.rows(); ++row) {
    if (!HasEntries(rows, row)) continue;
    if (label.is_mixed) {
      for (int j = 0; j < in_nodes_; ++j) {
        if (rows(row, j) != 0) label.before.parts.push_back({0, j, rows(row, j)});
      }
    } else {
      label.before.parts.push_back({0, row, 1.0F});
    }
    label.before.EndRow();
  }
}

// Lists which rows of the labels' products make each node of y.
void GraphConv::LinkOutput(const std::array<Eigen::MatrixXf, kLabelCount>& mixing) {
  // The row of a label's product that belongs to a node: of y if it is mixed before, else of x.
  std::array<std::vector<int>, kLabelCount> row_of;
  for (std::size_t k = 0; k < kLabelCount; ++k) {
    const Eigen::MatrixXf rows =
        labels_[k].is_mixed ? Eigen::MatrixXf(mixing[k].transpose()) : mixing[k];
    int next = 0;
    for (int row = 0; row < rows.rows(); ++row) {
      row_of[k].push_back(HasEntries(rows, row) ? next++ : -1);
    }
  }
  for (int i = 0; i < out_nodes_; ++i) {
    for (std::size_t k = 0; k < kLabelCount; ++k) {
      const int input = static_cast<int>(k);
      if (labels_[k].is_mixed) {
        const int row = row_of[k][static_cast<std::size_t>(i)];
        if (row >= 0) after_.parts.push_back({input, row, 1.0F});
        continue;
      }
      for (int j = 0; j < in_nodes_; ++j) {
        const float share = mixing[k](j, i);
        if (share == 0) continue;
        after_.parts.push_back({input, row_of[k][static_cast<std::size_t>(j)], share});
      }
    }
    after_.EndRow();
  }
}

std::size_t GraphConv::ScratchSize(int frames) const {
  if (together_) return kLabelCount * Size(frames, out_nodes_, in_channels_);
  std::size_t size = 0;
  for (const OneLabel& label : labels_) {
    if (label.before.rows() > 0) size += Size(frames, label.rows, in_channels_);
    size += Size(frames, label.rows, out_channels_);
  }
  return size;
}

// One product of three terms per row of y.
void GraphConv::RunTogether(const net::RowKernels& kernels, const float* x, int frames, bool relu,
                            float* y, float* scratch) const noexcept {
  const RowMixture::Input input{x, std::ptrdiff_t{in_nodes_} * in_channels_};
  std::array<RowTerm, kLabelCount> terms;
  for (std::size_t k = 0; k < kLabelCount; ++k) {
    const Sparse& before = labels_[k].before;
    kernels.mix(
        {before.begins, before.parts, {&input, 1}, frames, in_channels_, nullptr, false, scratch});
    terms[k] = {scratch, in_channels_};
    scratch += Size(frames, out_nodes_, in_channels_);
  }
  kernels.product({&all_, terms, frames * out_nodes_, constant_.data(), out_nodes_, nullptr, relu,
                   y, out_channels_});
}

void GraphConv::Run(const net::RowKernels& kernels, const float* x, int frames, bool relu, float* y,
                    float* scratch) const noexcept {
  if (together_) return RunTogether(kernels, x, frames, relu, y, scratch);
  const RowMixture::Input input{x, std::ptrdiff_t{in_nodes_} * in_channels_};
  std::array<RowMixture::Input, kLabelCount> products;
  for (std::size_t k = 0; k < kLabelCount; ++k) {
    const OneLabel& label = labels_[k];
    const int rows = frames * label.rows;
    const float* from = x;
    if (label.before.rows() > 0) {
      kernels.mix({label.before.begins,
                   label.before.parts,
                   {&input, 1},
                   frames,
                   in_channels_,
                   nullptr,
                   false,
                   scratch});
      from = scratch;
      scratch += Size(frames, label.rows, in_channels_);
    }
    const RowTerm term{from, in_channels_};
    kernels.product(
        {&label.weight, {&term, 1}, rows, nullptr, 1, nullptr, false, scratch, out_channels_});
    products[k] = {scratch, std::ptrdiff_t{label.rows} * out_channels_};
    scratch += Size(frames, label.rows, out_channels_);
  }
  kernels.mix(
      {after_.begins, after_.parts, products, frames, out_channels_, constant_.data(), relu, y});
}

}  // namespace styled::stgcn

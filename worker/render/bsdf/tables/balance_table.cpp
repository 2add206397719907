#include "render/bsdf/tables/balance_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "render/bsdf/boundary_scatter.h"
#include "render/bsdf/tables/sqr.h"

namespace tessera::render {

namespace {

constexpr float kSmallestAlpha = 1e-4f;  // as ggx_of() of microfacet.h

constexpr int kTurnedRows = 13;  // of anisotropic facets, whose rows are computed together

/// A place between the nodes of one axis: `low` and the one after it, which has the share t.
struct Place {
  int low;
  double t;

  Place(double position, int nodes)
      : low(std::clamp(static_cast<int>(position), 0, std::max(nodes - 2, 0))),
        t(std::clamp(position - low, 0.0, 1.0)) {}
};

/// Anderson's acceleration of the fixed-point iteration x -> x + step(x) [Anderson 1965]: plain iteration
/// takes hundreds of steps where a boundary hardly spreads light.
class Acceleration {
 public:
  /// Moves x on; `step` is that at x.
  void advance(std::vector<double>& x, const std::vector<double>& step) {
    if (!last_x_.empty()) {
      if (changes_.size() == kMemory) changes_.erase(changes_.begin());
      Change& change = changes_.emplace_back();
      for (std::size_t i = 0; i < x.size(); ++i) {
        change.x.push_back(x[i] - last_x_[i]);
        change.step.push_back(step[i] - last_step_[i]);
      }
    }
    last_x_ = x, last_step_ = step;
    const std::vector<double> shares = combination(step);
    for (std::size_t i = 0; i < x.size(); ++i) {
      double moved = step[i];
      for (std::size_t k = 0; k < changes_.size(); ++k)
        moved -= shares[k] * (changes_[k].x[i] + changes_[k].step[i]);
      x[i] += std::clamp(moved, -kFarthest, kFarthest);
    }
  }

 private:
  static constexpr std::size_t kMemory = 8;
  static constexpr double kFarthest = 0.5;

  struct Change {
    std::vector<double> x, step;
  };

  /// The combination of the changes of step that comes closest to `step`: normal equations, by Gauss's
  /// elimination.
  std::vector<double> combination(const std::vector<double>& step) const {
    const std::size_t n = changes_.size();
    const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
      return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
    };
    std::vector<double> matrix(n * n), result(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < n; ++k) matrix[i * n + k] = product(changes_[i].step, changes_[k].step);
      matrix[i * n + i] *= 1 + 1e-10;
      matrix[i * n + i] += 1e-30;
      result[i] = product(changes_[i].step, step);
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i + 1; k < n; ++k) {
        const double factor = matrix[k * n + i] / matrix[i * n + i];
        for (std::size_t c = i; c < n; ++c) matrix[k * n + c] -= factor * matrix[i * n + c];
        result[k] -= factor * result[i];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) result[i] -= matrix[i * n + k] * result[k];
      result[i] /= matrix[i * n + i];
    }
    return result;
  }

  std::vector<double> last_x_, last_step_;
  std::vector<Change> changes_;
};

/// Shares of the light from each node (side, row, column) of a table that single scattering gives to the
/// nodes around where it goes, by their shares in interpolation. What s is at a node follows from the
/// integral there, and from no average over its surroundings: those would have to be undone again, which has
/// no stable solution.
class Transport {
 public:
  /// Rows lie between the smaller and the larger roughness, evenly in their square roots; one if these are
  /// equal.
  explicit Transport(const BalancedFacets& facets)
      : scattering_{std::max(facets.alpha_x, kSmallestAlpha), std::max(facets.alpha_y, kSmallestAlpha),
                    facets.beckmann, facets.separable_masking},
        eta_(facets.eta),
        rows_(facets.alpha_x == facets.alpha_y ? 1 : kTurnedRows),
        sides_(facets.eta > 0 ? 2 : 1) {
    const auto [low, high] = std::minmax(scattering_.alpha_x, scattering_.alpha_y);
    first_ = std::sqrt(low);
    step_ = (std::sqrt(high) - first_) / std::max(rows_ - 1, 1);
    count_ = static_cast<std::size_t>(sides_ * rows_ * kBalanceCosines);
    energy_.resize(count_ * count_);
    for (int side = 0; side < sides_; ++side) {
      for (int r = 0; r < rows_; ++r) {
        for (int c = 0; c < kBalanceCosines; ++c) integrate(side, r, c);
      }
    }
  }

  int rows() const { return rows_; }
  int sides() const { return sides_; }
  double first() const { return first_; }
  double step() const { return step_; }

  /// s with s_i (energy s)_i = 1.
  std::vector<double> balance() const {
    constexpr int kMostSteps = 60;
    constexpr double kPrecision = 1e-5;
    std::vector<double> x(count_, 0.0), step(count_), s(count_);
    Acceleration acceleration;
    for (int i = 0; i < kMostSteps; ++i) {
      std::ranges::transform(x, s.begin(), [](double log_s) { return std::exp(log_s); });
      double worst = 0;
      for (std::size_t n = 0; n < count_; ++n) {
        const double* row = energy_.data() + n * count_;
        const double sum = std::inner_product(row, row + count_, s.begin(), 0.0);
        // Half of what normalises: the whole would swing between two solutions of the alternating problem.
        step[n] = -0.5 * std::log(std::max(s[n] * sum, 1e-6));
        worst = std::max(worst, std::abs(step[n]));
      }
      if (worst < kPrecision) break;
      acceleration.advance(x, step);
    }
    return s;
  }

  /// Mean energy that is kept of diffuse light from above, evenly over the rows.
  double kept() const {
    double kept = 0, all = 0;
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < kBalanceCosines; ++c) {
        // 2 z dz = 4 x^3 dx
        const double x = c / (kBalanceCosines - 1.0),
                     weight = (c + 1 == kBalanceCosines ? 0.5 : 1) * x * x * x;
        const double* row = energy_.data() + static_cast<std::size_t>(node(0, r, c)) * count_;
        kept += weight * std::accumulate(row, row + count_, 0.0);
        all += weight;
      }
    }
    return kept / all;
  }

 private:
  int node(int side, int row, int column) const { return (side * rows_ + row) * kBalanceCosines + column; }

  /// Fills the row of one node.
  void integrate(int side, int row, int column) {
    static const HalfDisk coarse(377, 233), fine(2584, 1597);
    // Straight along the surface nothing is defined; the limit is.
    const double z = std::max(sqr(column / (kBalanceCosines - 1.0)), 1e-9), sine = std::sqrt(1 - sqr(z));
    const double cosine_phi = azimuth(row), sine_phi = std::sqrt(1 - sqr(cosine_phi));
    double* energies = energy_.data() + static_cast<std::size_t>(node(side, row, column)) * count_;
    scatter_once(sine * cosine_phi, sine * sine_phi, z, scattering_, side == 0 ? eta_ : 1 / eta_,
                 (rows_ == 1 ? fine : coarse).points, rows_ > 1,
                 [&](double x, double y, double to, double energy) {
                   spread(x, y, std::abs(to), to > 0 ? side : 1 - side, energy, energies);
                 });
  }

  /// `energy` on the nodes around a direction.
  void spread(double x, double y, double z, int side, double energy, double* energies) const {
    const Place column(std::sqrt(z) * (kBalanceCosines - 1), kBalanceCosines);
    Place row(0, rows_);
    if (rows_ > 1) {
      const double tangent2 = sqr(x) + sqr(y);
      const double alpha2 = tangent2 > 0 ? scattering_.stretched2(x, y) / tangent2 : sqr(scattering_.alpha_x);
      row = Place((std::sqrt(std::sqrt(alpha2)) - first_) / step_, rows_);
    }
    double* to = energies + node(side, row.low, column.low);
    to[0] += energy * (1 - row.t) * (1 - column.t);
    to[1] += energy * (1 - row.t) * column.t;
    if (rows_ == 1) return;
    to[kBalanceCosines] += energy * row.t * (1 - column.t);
    to[kBalanceCosines + 1] += energy * row.t * column.t;
  }

  /// Cosine of the azimuth along which roughness is that of a row.
  double azimuth(int row) const {
    if (rows_ == 1) return 1;
    const double alpha2 = sqr(sqr(first_ + row * step_)), y2 = sqr(scattering_.alpha_y);
    return std::sqrt(std::clamp((alpha2 - y2) / (sqr(scattering_.alpha_x) - y2), 0.0, 1.0));
  }

  ScatteringFacets scattering_;
  double eta_;
  int rows_, sides_;
  double first_ = 0, step_ = 0;
  std::size_t count_ = 0;
  std::vector<double> energy_;  // count_ rows of count_
};

/// Rows [row, row + count) of a table, all alike, or rows from `row` on, one for each of the facets'
/// roughnesses.
void write_rows(const BalancedFacets& facets, int row, int count, float* out) {
  const Transport transport(facets);
  const std::vector<double> s = transport.balance();
  const double kept = transport.kept();
  const int end = row + (transport.rows() == 1 ? count : transport.rows());
  for (int r = row; r < end; ++r) {
    out[kBalanceKept + r] = static_cast<float>(kept);
    const int node_row = transport.rows() == 1 ? 0 : r - row;
    for (int side = 0; side < transport.sides(); ++side) {
      const double* from = s.data() + (side * transport.rows() + node_row) * kBalanceCosines;
      float* to = out + kBalanceFactors + (side * kBalanceRows + r) * kBalanceCosines;
      for (int c = 0; c < kBalanceCosines; ++c) to[c] = static_cast<float>(from[c]);
    }
  }
  if (transport.rows() == 1) return;
  out[kBalanceFirst] = static_cast<float>(transport.first());
  out[kBalancePerRow] = static_cast<float>(1 / transport.step());
}

}  // namespace

std::int32_t append_balance_table(const BalancedFacets& facets, MaterialTable& table) {
  const std::size_t offset = table.coat_tables.size();
  const int sides = facets.eta > 0 ? 2 : 1;
  table.coat_tables.resize(
      offset + kBalanceFactors + static_cast<std::size_t>(sides * kBalanceRows * kBalanceCosines), 1.0f);
  float* out = table.coat_tables.data() + offset;
  out[kBalanceFirst] = out[kBalancePerRow] = 0;
  if (!facets.textured) {
    write_rows(facets, 0, kBalanceRows, out);
    return static_cast<std::int32_t>(offset);
  }
  // Row 0 is smooth and stays at 1.
  out[kBalancePerRow] = kBalanceRows - 1;
  for (int r = 1; r < kBalanceRows; ++r) {
    BalancedFacets one = facets;
    one.alpha_x = one.alpha_y = static_cast<float>(sqr(r / (kBalanceRows - 1.0)));
    write_rows(one, r, 1, out);
  }
  return static_cast<std::int32_t>(offset);
}

}  // namespace tessera::render

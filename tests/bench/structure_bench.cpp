// Structures on a mesh that is made here: build time, memory and speed against the number of triangles, with
// Embree on the same rays.
//   structure_bench_ISA growth [MOST [PLOT]]  tables, from 10^3 triangles to 10^MOST (default 6); PLOT: a
//   .png
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/cpu_time.h"
#include "plot/log_log_plot.h"
#include "render/accel/structure/structure_query.h"
#include "stress/geometry/structure_tables.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Contender {
  const char* name;
  StructureKind kind;
};
constexpr Contender kContenders[] = {
    {"bvh-median", StructureKind::kBvhMedian},   {"bvh-sah", StructureKind::kBvhSah},
    {"sphere-tree", StructureKind::kSphereTree}, {"grid", StructureKind::kGrid},
    {"octree", StructureKind::kOctree},          {"bsp", StructureKind::kBsp},
    {"kd-median", StructureKind::kKdMedian},     {"kd-sah", StructureKind::kKdSah}};

const TextureTable kNoTextures;

std::unique_ptr<SceneStructure> build(const Contender& one, const ShapeTable& table) {
  auto built = build_structure(one.kind, table, kNoTextures, structure_kernel().analytic, {.wide = true});
  if (!built.ok()) std::fprintf(stderr, "%s: %s\n", one.name, std::string(built.status().message()).c_str());
  return built.ok() ? *std::move(built) : nullptr;
}

double seconds() { return base::in_seconds(base::thread_cpu_time()); }

/// A wavy sphere of about n triangles, as a mesh of parallels and meridians.
ShapeTable wavy(double n) {
  const int rows = std::max(4, static_cast<int>(std::lround(std::sqrt(n / 4))));
  const auto at = [&](int i, int j) {
    const double t = M_PI * i / rows, p = M_PI * (j % (2 * rows)) / rows;
    const Point d{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
    return d * (1 + 0.1 * std::sin(7 * d.x) * std::sin(9 * d.y + 1) * std::sin(8 * d.z));
  };
  TableMaker maker;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < 2 * rows; ++j) {
      maker.add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      maker.add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  maker.end_mesh();
  return maker.take();
}

/// Millions of rays a second from about the mesh towards it.
template <class Trace>
double speed(Trace&& trace) {
  RayBatch rays;
  Numbers random(31);
  double spent = 0;
  std::int64_t traced = 0;
  while (spent < 0.3) {
    for (int i = 0; i < RayBatch::kSize; ++i)
      rays.aim(i, random.direction() * 2.5, random.direction() * random());
    const double start = seconds();
    trace(rays);
    spent += seconds() - start;
    traced += RayBatch::kSize;
  }
  return 1e-6 * static_cast<double>(traced) / spent;
}

/// Also draws rays a second over the number of triangles, where `plot` names a file.
int show_growth(int most, const std::string& plot) {
  client::LogLogPlot drawn{.title = "Rays towards a wavy sphere, one thread",
                           .x_label = "triangles",
                           .y_label = "million rays a second"};
  drawn.series.push_back({.name = "embree", .dashed = true});
  for (const Contender& one : kContenders) drawn.series.push_back({.name = one.name});
  std::printf("| triangles | structure | build CPU s | MB | Mray/s |\n|---|---|---|---|---|\n");
  for (int exponent = 3; exponent <= most; ++exponent) {
    const ShapeTable table = wavy(std::pow(10.0, exponent));
    const TracedTable embree(table, false);
    const double reference = speed([&](RayBatch& rays) { embree.nearest(rays); });
    const double triangles = std::pow(10.0, exponent);
    drawn.series[0].points.push_back({triangles, reference});
    std::printf("| 1e%d | embree | | | %.2f |\n", exponent, reference);
    for (std::size_t c = 0; c < std::size(kContenders); ++c) {
      const Contender& one = kContenders[c];
      const double start = seconds();
      const auto structure = build(one, table);
      const double spent = seconds() - start;
      if (structure == nullptr) continue;
      const auto query = structure_kernel().make_query(*structure);
      const double rate = speed([&](RayBatch& r) {
        query->nearest(r.arrays(), RayBatch::kSize, false, {r.t, r.u, r.v, r.primitive, r.shape, r.instance});
      });
      drawn.series[1 + c].points.push_back({triangles, rate});
      std::printf("| 1e%d | %s | %.2f | %.1f | %.2f |\n", exponent, one.name, spent,
                  1e-6 * static_cast<double>(structure->memory_bytes()), rate);
      std::fflush(stdout);
    }
  }
  if (plot.empty()) return 0;
  const absl::Status drawing = client::write_plot(drawn, plot);
  if (!drawing.ok()) std::fprintf(stderr, "%s\n", std::string(drawing.message()).c_str());
  return drawing.ok() ? 0 : 1;
}

}  // namespace

int run_structure_bench(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what != "growth") return 2;
  return show_growth(argc > 2 ? std::atoi(argv[2]) : 6, argc > 3 ? argv[3] : "");
}

}  // namespace tessera::render::TESSERA_ISA

int main(int argc, char** argv) { return tessera::render::TESSERA_ISA::run_structure_bench(argc, argv); }

// Structures on scenes that are made here: build time, memory and speed against the number of triangles, with
// Embree on the same rays; and heat maps of what camera rays visit.
//   structure_bench_ISA growth [MOST]     tables, from 10^3 triangles to 10^MOST (default 6)
//   structure_bench_ISA maps FILE.png     a stadium (above) and a mesh alone (below), a column a structure
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/cpu_time.h"
#include "image/png.h"
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

void print_growth(int most) {
  std::printf("| triangles | structure | build CPU s | MB | Mray/s |\n|---|---|---|---|---|\n");
  for (int exponent = 3; exponent <= most; ++exponent) {
    const ShapeTable table = wavy(std::pow(10.0, exponent));
    const TracedTable embree(table, false);
    const double reference = speed([&](RayBatch& rays) { embree.nearest(rays); });
    std::printf("| 1e%d | embree | | | %.2f |\n", exponent, reference);
    for (const Contender& one : kContenders) {
      const double start = seconds();
      const auto structure = build(one, table);
      const double spent = seconds() - start;
      if (structure == nullptr) continue;
      const auto query = structure_kernel().make_query(*structure);
      const double rate = speed([&](RayBatch& r) {
        query->nearest(r.arrays(), RayBatch::kSize, false, {r.t, r.u, r.v, r.primitive, r.shape, r.instance});
      });
      std::printf("| 1e%d | %s | %.2f | %.1f | %.2f |\n", exponent, one.name, spent,
                  1e-6 * static_cast<double>(structure->memory_bytes()), rate);
      std::fflush(stdout);
    }
  }
}

constexpr int kSide = 160;

/// From black by blue, red and yellow to white, evenly in the logarithm of the count: 1 to 1024.
void paint(double visits, float (&rgb)[3]) {
  const double x = std::clamp(std::log2(std::max(visits, 1.0)) / 10, 0.0, 1.0) * 4;
  constexpr double kStops[5][3] = {
      {0, 0, 0}, {0.05, 0.05, 0.5}, {0.7, 0.02, 0.05}, {0.95, 0.6, 0}, {1, 1, 1}};
  const int stop = std::min(3, static_cast<int>(x));
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<float>(std::lerp(kStops[stop][c], kStops[stop + 1][c], x - stop));
}

/// Nodes that the rays of a camera open, and primitives that they test, a pixel each.
void map_visits(const ShapeTable& table, const Contender& one, int x0, int y0, client::Image& image) {
  const auto structure = build(one, table);
  if (structure == nullptr) return;
  const auto query = structure_kernel().make_query(*structure);
  const Point eye{2.6, -2.2, 1.5}, along = unit(Point{0, 0, 0} - eye), right = unit({-along.y, along.x, 0});
  const Point up{right.y * -along.z, right.x * along.z, -right.x * along.y + right.y * along.x};
  RayBatch rays;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      // One at a time: the query counts tests for all rays of a call.
      const double sx = 1.2 * (2 * (x + 0.5) / kSide - 1) * 0.45,
                   sy = -1.2 * (2 * (y + 0.5) / kSide - 1) * 0.45;
      rays.set(0, eye, along + right * sx + up * -sy);
      const RayVisits before = query->visits();
      query->nearest(rays.arrays(), 1, true,
                     {rays.t, rays.u, rays.v, rays.primitive, rays.shape, rays.instance});
      const RayVisits visits = query->visits() - before;
      float rgb[3];
      paint(static_cast<double>(visits.nodes + visits.primitives), rgb);
      const std::size_t pixel =
          static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(image.data.width()) +
          static_cast<std::size_t>(x0 + x);
      for (std::size_t c = 0; c < 3; ++c) image.channels[c].values[pixel] = rgb[c];
    }
  }
}

int write_maps(const std::string& file) {
  constexpr int kGap = 4, kStep = kSide + kGap;
  constexpr int kColumns = static_cast<int>(std::size(kContenders));
  client::Image image;
  image.data = image.display = {0, 0, kColumns * kStep - kGap, 2 * kStep - kGap};
  for (const char* name : {"R", "G", "B"}) std::ranges::fill(image.add(name).values, 0.2f);
  TableMaker alone;
  alone.add_mesh(displaced_sphere(4), {0.3, -0.2, 0.1}, 0.8);
  alone.end_mesh();
  const ShapeTable tables[2] = {stadium(), alone.take()};
  for (int c = 0; c < kColumns; ++c) {
    for (int row = 0; row < 2; ++row) map_visits(tables[row], kContenders[c], c * kStep, row * kStep, image);
  }
  const absl::Status status = client::write_png(image, file);
  if (!status.ok()) std::fprintf(stderr, "%s\n", std::string(status.message()).c_str());
  return status.ok() ? 0 : 1;
}

}  // namespace

int run_structure_bench(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "maps" && argc > 2) return write_maps(argv[2]);
  if (what != "growth") return 2;
  print_growth(argc > 2 ? std::atoi(argv[2]) : 6);
  return 0;
}

}  // namespace tessera::render::TESSERA_ISA

int main(int argc, char** argv) { return tessera::render::TESSERA_ISA::run_structure_bench(argc, argv); }

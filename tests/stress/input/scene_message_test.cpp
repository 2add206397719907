// The worker takes a Scene message from anybody: bad numbers in each of its fields, without an importer
// before it.
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <string>

#include "google/protobuf/message.h"
#include "import/import.h"
#include "stress/input/input_judge.h"
#include "stress/input/sample_files.h"
#include "support/long_form.h"
#include "support/process/temp_dir.h"

namespace tessera::stress {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

bool is_number(const FieldDescriptor* field) {
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
    case FieldDescriptor::CPPTYPE_STRING:
    case FieldDescriptor::CPPTYPE_BOOL:
      return false;
    default:
      return true;
  }
}

constexpr double kBadDoubles[] = {std::numeric_limits<double>::quiet_NaN(),
                                  std::numeric_limits<double>::infinity(),
                                  -std::numeric_limits<double>::infinity(),
                                  1e300,
                                  -1e300,
                                  1e38,
                                  -1e38,
                                  1e17,
                                  1e12,
                                  -1e12,
                                  1e-45,
                                  1e-12,
                                  0,
                                  -1};
constexpr std::uint64_t kBadIntegers[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, ~std::uint64_t{0}};

/// Puts bad number `which` into element `index` (of a repeated field). Numbers beyond a field's type are cut
/// to it.
void put(Message& message, const FieldDescriptor* field, int index, std::size_t which) {
  const auto* reflection = message.GetReflection();
  const double real = kBadDoubles[which % std::size(kBadDoubles)];
  const std::uint64_t whole = kBadIntegers[which % std::size(kBadIntegers)];
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_FLOAT: {
      const auto x = static_cast<float>(real);
      index < 0 ? reflection->SetFloat(&message, field, x)
                : reflection->SetRepeatedFloat(&message, field, index, x);
      break;
    }
    case FieldDescriptor::CPPTYPE_DOUBLE:
      index < 0 ? reflection->SetDouble(&message, field, real)
                : reflection->SetRepeatedDouble(&message, field, index, real);
      break;
    case FieldDescriptor::CPPTYPE_UINT32:
      index < 0 ? reflection->SetUInt32(&message, field, static_cast<std::uint32_t>(whole))
                : reflection->SetRepeatedUInt32(&message, field, index, static_cast<std::uint32_t>(whole));
      break;
    case FieldDescriptor::CPPTYPE_UINT64:
      reflection->SetUInt64(&message, field, whole);
      break;
    case FieldDescriptor::CPPTYPE_ENUM:
      reflection->SetEnumValue(&message, field, static_cast<int>(whole));
      break;
    default:
      FAIL() << field->full_name() << " is of a kind that this test does not know";
  }
}

std::size_t ways(const FieldDescriptor* field) {
  const bool real = field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT ||
                    field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  return real ? std::size(kBadDoubles) : std::size(kBadIntegers);
}

/// Every number in `message` and below, in order; `visit(message, field, index, path)`.
using Visit = std::function<void(Message&, const FieldDescriptor*, int, const std::string&)>;
void for_each_number(Message& message, const std::string& path, const Visit& visit) {
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string here = path + "." + std::string(field->name());
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string at = field->is_repeated() ? here + "[" + std::to_string(i) + "]" : here;
      if (is_number(field)) {
        visit(message, field, field->is_repeated() ? i : -1, at);
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        for_each_number(field->is_repeated() ? *reflection->MutableRepeatedMessage(&message, field, i)
                                             : *reflection->MutableMessage(&message, field),
                        at, visit);
      }
    }
  }
}

/// Names of the floating-point fields of a message and all that it may hold.
void fields_of(const Descriptor* descriptor, std::set<const Descriptor*>& seen,
               std::set<std::string>& names) {
  if (!seen.insert(descriptor).second) return;
  for (int i = 0; i < descriptor->field_count(); ++i) {
    const FieldDescriptor* field = descriptor->field(i);
    const auto type = field->cpp_type();
    if (type == FieldDescriptor::CPPTYPE_MESSAGE) fields_of(field->message_type(), seen, names);
    if (type == FieldDescriptor::CPPTYPE_FLOAT || type == FieldDescriptor::CPPTYPE_DOUBLE)
      names.insert(std::string(field->full_name()));
  }
}

class SceneMessage : public testing::Test {
 protected:
  void SetUp() override {
    write_blobs_of_the_sample(folder_.path());
    const auto path = folder_.path() / "everything.textproto";
    write_bytes(path, read_bytes("tests/stress/input/everything.textproto"));
    auto imported = client::import_scene(path);
    ASSERT_TRUE(imported.ok()) << imported.status();
    samples_[0] = *std::move(imported);
    // A scene has one camera: one each of the other kinds with numbers, and light to see by.
    for (int i = 1; i < kSamples; ++i) {
      v1::Scene& other = samples_[i].scene;
      *other.mutable_camera() = samples_[0].scene.camera();
      other.mutable_camera()->clear_distortion();
      other.mutable_camera()->clear_viewpoint();
      other.mutable_camera()->clear_focus_point();  // nothing is there
      *other.mutable_film() = samples_[0].scene.film();
      other.add_lights()->mutable_infinite()->mutable_radiance()->set_constant(1);
    }
    v1::OrthographicCamera& orthographic = *samples_[1].scene.mutable_camera()->mutable_orthographic();
    orthographic.set_lens_radius(0.01f);
    orthographic.set_focal_distance(5);
    *orthographic.mutable_aperture() = samples_[0].scene.camera().perspective().aperture();
    // Barrels are those of perspective cameras.
    orthographic.mutable_aperture()->clear_barrel_length();
    orthographic.mutable_aperture()->clear_barrel_radius();
    v1::FisheyeCamera& fisheye = *samples_[2].scene.mutable_camera()->mutable_fisheye();
    fisheye.set_fov_degrees(180);
    fisheye.set_circle_degrees(170);
    samples_[2].scene.mutable_camera()->mutable_distortion()->mutable_polynomial()->add_angle(1);
    v1::Camera& around = *samples_[3].scene.mutable_camera();
    around.mutable_cylindrical()->set_fov_degrees(300);
    around.clear_screen_window();  // it has none
    around.mutable_shutter()->mutable_trapezoid()->set_opening(0.2);
    around.mutable_shutter()->mutable_trapezoid()->set_closing(0.3);
    v1::LensCamera& lens = *samples_[4].scene.mutable_camera()->mutable_lens();
    ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(kLens, &lens));
    *samples_[5].scene.mutable_camera()->mutable_lens() = lens;
    lens.set_f_number(4);
    samples_[5].scene.mutable_camera()->mutable_lens()->set_stop_diameter_mm(12);
    const auto merge = [](const std::string& more, v1::Scene& scene) {
      v1::Scene read;
      ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(more, &read)) << more;
      scene.MergeFrom(read);
    };
    samples_[6].scene.mutable_camera()->clear_screen_window();
    merge(
        R"(camera { panorama { longitude_min_degrees: -90 longitude_max_degrees: 90 latitude_min_degrees: -80
                                 latitude_max_degrees: 85 } }
             rig { stereo { interocular_distance: 0.1 convergence_distance: 5 pole_merge_from_degrees: 60
                            pole_merge_to_degrees: 75 } })",
        samples_[6].scene);
    merge(R"(camera { fisheye { fov_degrees: 90 } distortion { opencv_fisheye { k1: 0.01 k2: 0.01 k3: 0.001
                                                                             k4: 0.001 } } }
             rig { list { places { camera_from_view { elements: [1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } } })",
          samples_[7].scene);
    merge(
        "camera { viewpoint { pole_merge_from_degrees: 60 pole_merge_to_degrees: 75 } panorama { "
        "lens_radius: "
        "0.01 focal_distance: 5 } }",
        samples_[8].scene);
    *samples_[8].scene.mutable_camera()->mutable_panorama()->mutable_aperture() =
        samples_[1].scene.camera().orthographic().aperture();
    samples_[8].scene.mutable_camera()->clear_screen_window();
    v1::PerspectiveCamera& tilted = *samples_[9].scene.mutable_camera()->mutable_perspective();
    // A lens has a barrel or is tilted.
    tilted.mutable_aperture()->clear_barrel_length(), tilted.mutable_aperture()->clear_barrel_radius();
    ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString("x_degrees: 2 y_degrees: 1 focal_length: 0.5",
                                                              tilted.mutable_tilt()));
    merge("rig { grid { columns: 2 rows: 2 spacing_x: 0.1 spacing_y: 0.1 convergence_distance: 5 } }",
          samples_[9].scene);
    v1::PinholeCamera& pinhole = *samples_[10].scene.mutable_camera()->mutable_pinhole();
    ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(kPinhole, &pinhole));
    samples_[10].scene.mutable_film()->mutable_photographic_exposure()->clear_f_number();
    samples_[10].scene.mutable_film()->mutable_photographic_exposure()->set_t_number(180);
    v1::PerspectiveCamera& by_focal_length = *samples_[11].scene.mutable_camera()->mutable_perspective();
    by_focal_length.clear_fov_degrees();
    by_focal_length.set_focal_length_mm(50);
    samples_[11].scene.mutable_film()->mutable_photographic_exposure()->Clear();
    samples_[11].scene.mutable_film()->mutable_photographic_exposure()->set_ev100(12);
    v1::Scene& readings = samples_[12].scene;
    readings.mutable_camera()->Clear();
    readings.mutable_film()->mutable_filter()->Clear();
    merge(kReadings, readings);
  }

  static constexpr const char* kLens = R"(
      lens { surfaces { thickness_mm: 3 diameter_mm: 20 stop: true }
             surfaces { radius_mm: 50 thickness_mm: 6 diameter_mm: 24 index: 1.5 conic: -0.5 aspheric: 1e-8
                        coating { index: 1.38 thickness_nm: 100 } }
             surfaces { radius_mm: -90 thickness_mm: 1 diameter_mm: 24 }
             surfaces { radius_mm: 900 thickness_mm: 2 diameter_mm: 24 cylindrical: true axis_degrees: 30
                        dispersion { abbe { index: 1.6 number: 50 } } }
             surfaces { thickness_mm: 1 diameter_mm: 24 dispersion { cauchy { a: 1.5 b: 0.004 c: 0.0001 } } }
             surfaces { thickness_mm: 60 diameter_mm: 24 } }
      film_diagonal_mm: 40 focus_distance: 5 blades: 6 blade_degrees: 10 units_per_mm: 0.001)";
  static constexpr const char* kPinhole = R"(
      hole_mm: 0.3 film_distance_mm: 50 film_diagonal_mm: 40 scene_distance: 5 wavelength_nm: 550
      units_per_mm: 0.001)";
  static constexpr const char* kReadings = R"(
      camera { probes {
        probes { kind: CONE field_degrees: 20 point { x: 0.1 y: 0.2 z: 0.3 } axis { z: 1 } pixels: 2 }
        probes { kind: HALF_CYLINDER axis { z: 1 } front { x: 1 } offset: 0.01 pixels_of_cells: [1, 2, 1, 1]
                 plane { corner { x: -1 } edge_u { x: 2 } edge_v { y: 2 } columns: 2 rows: 2 } }
        probes { kind: FAR_FIELD axis { z: -1 } offset: 10 disk { middle { x: 1 y: 1 z: 1 } radius: 5 } }
        probes { kind: EXITANCE offset: 0.01 sphere { middle { x: 1 y: 1 z: 1 } radius: 0.5 } } } }
      film { filter { kind: BOX radius_x: 0.49 radius_y: 0.49 } }
      settings { path_sharing: PATH_SHARING_OFF reconstruction: RECONSTRUCTION_SAMPLE })";
  static constexpr int kSamples = 13;

  support::TempDir folder_;
  client::ImportedScene samples_[kSamples];
};

TEST_F(SceneMessage, TheSampleHasEveryNumberThatASceneCanHave) {
  std::set<const Descriptor*> seen;
  std::set<std::string> names;
  fields_of(v1::Scene::descriptor(), seen, names);
  for (client::ImportedScene& sample : samples_) {
    for_each_number(sample.scene, "", [&](Message&, const FieldDescriptor* field, int, const std::string&) {
      names.erase(std::string(field->full_name()));
    });
  }
  EXPECT_TRUE(names.empty()) << *names.begin() << " is not in everything.textproto";
}

TEST_F(SceneMessage, BadNumbersInEveryField) {
  struct BadNumber {
    const client::ImportedScene* sample;
    std::size_t number, way;
    std::string path;
  };
  InputJudge judge;
  std::vector<BadNumber> cases;
  for (client::ImportedScene& sample : samples_) {
    const std::uint64_t rendered = judge.tally().rendered;
    ASSERT_EQ(judge.judge_scene(sample.scene, sample.blobs), "");
    EXPECT_EQ(judge.tally().rendered, rendered + 1) << sample.scene.camera().ShortDebugString();
    std::size_t numbers = 0;
    for_each_number(sample.scene, "",
                    [&](Message&, const FieldDescriptor* field, int, const std::string& path) {
                      for (std::size_t way = 0; way < ways(field); ++way)
                        cases.push_back({&sample, numbers, way, path});
                      ++numbers;
                    });
  }
  std::mt19937 random(2);
  for (std::size_t i = cases.size(); i > 1; --i) std::swap(cases[i - 1], cases[random() % i]);
  cases.resize(std::min<std::size_t>(cases.size(), test::long_form() ? 600 : 60));

  for (const BadNumber& c : cases) {
    v1::Scene scene = c.sample->scene;
    std::size_t i = 0;
    for_each_number(scene, "",
                    [&](Message& message, const FieldDescriptor* field, int index, const std::string&) {
                      if (i++ == c.number) put(message, field, index, c.way);
                    });
    EXPECT_EQ(judge.judge_scene(scene, c.sample->blobs), "") << c.path << ", way " << c.way;
  }
  std::printf("messages of %zu: %s\n", cases.size(), judge.tally().to_string().c_str());
}

}  // namespace
}  // namespace tessera::stress

#include "stress/input/sample_files.h"

#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::stress {
namespace {

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// x y z, normal, u v of the four corners.
constexpr float kCorners[4][8] = {{-1, 0, -1, 0, 1, 0, 0, 0},
                                  {1, 0, -1, 0, 1, 0, 1, 0},
                                  {1, 0, 1, 0, 1, 0, 1, 1},
                                  {-1, 0, 1, 0, 1, 0, 0, 1}};
constexpr std::uint32_t kFaces[2][3] = {{0, 2, 1}, {0, 3, 2}};

wire::MeshData square() {
  wire::MeshData mesh;
  for (const auto& corner : kCorners) {
    mesh.positions.insert(mesh.positions.end(), corner, corner + 3);
    mesh.normals.insert(mesh.normals.end(), corner + 3, corner + 6);
    mesh.uvs.insert(mesh.uvs.end(), corner + 6, corner + 8);
  }
  for (const auto& face : kFaces) mesh.indices.insert(mesh.indices.end(), face, face + 3);
  return mesh;
}

std::string volume_blob(const std::vector<float>& samples) {
  wire::VolumeView volume;
  volume.nx = volume.ny = volume.nz = 2;
  volume.channels = 1;
  volume.samples = samples;
  return wire::encode_volume(volume);
}

std::string ply_header(const char* format) {
  std::string text = absl::StrCat("ply\nformat ", format, " 1.0\nelement vertex 4\n");
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "u", "v"})
    absl::StrAppend(&text, "property float ", name, "\n");
  return text + "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
}

void append(std::string& bytes, std::uint32_t word, bool big_endian) {
  char raw[4];
  std::memcpy(raw, &word, 4);
  if (big_endian) std::reverse(raw, raw + 4);
  bytes.append(raw, 4);
}

std::uint32_t word_of(float x) {
  std::uint32_t word;
  std::memcpy(&word, &x, 4);
  return word;
}

}  // namespace

void write_bytes(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::remove(path);  // writing over it makes some file systems wait for the disk
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_image(const std::filesystem::path& path, int width, const std::vector<float>& rgb, bool half) {
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output) return;
  const std::string ending = path.extension().string();
  const auto format = half               ? OIIO::TypeDesc::HALF
                      : ending == ".png" ? OIIO::TypeDesc::UINT16
                                         : OIIO::TypeDesc::FLOAT;
  const int height = static_cast<int>(rgb.size()) / (3 * width);
  if (output->open(path.string(), OIIO::ImageSpec(width, height, 3, format))) {
    output->write_image(OIIO::TypeDesc::FLOAT, rgb.data());
    output->close();
  }
}

void write_blobs_of_the_sample(const std::filesystem::path& folder) {
  write_bytes(folder / "square.mesh", wire::encode_mesh(square()));
  write_bytes(folder / "paint.f32", bytes_of<float>({0.1f, 0.5f, 0.9f, 0.3f}));
  write_bytes(folder / "ball.volume", volume_blob({-1, 1, 1, 1, 1, 1, 1, 1}));
  write_bytes(folder / "density.volume", volume_blob({1, 2, 3, 4, 5, 6, 7, 8}));
  write_bytes(folder / "points.f32",
              bytes_of<float>({0, 0, 0, .1f, .1f, .5f, 0, .1f, -.1f, 1, 0, .05f, 0, 1.5f, 0, .05f}));
  write_bytes(folder / "starts.u32", bytes_of<std::uint32_t>({0}));
  write_bytes(folder / "normals.f32", bytes_of<float>({0, 0, 1, 0, 0, 1, 0, 1, 1, 1, 0, 1}));
  write_bytes(folder / "params.f32", bytes_of<float>({0, 1}));
  write_image(folder / "image.exr", 2, {.2f, .4f, .6f, .8f, .6f, .4f, .2f, .1f, .3f, .9f, .9f, .9f});
  write_image(folder / "sky.exr", 4, std::vector<float>(24, 0.5f));
  write_bytes(folder / "lamp.ies",
              "IES:LM-63-2019\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n100 80 0\n");
}

BinaryFile binary_ply(bool big_endian) {
  BinaryFile file;
  file.bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian");
  file.first_number = file.bytes.size();
  file.numbers = 32;
  file.big_endian = big_endian;
  for (const auto& corner : kCorners) {
    for (const float x : corner) append(file.bytes, word_of(x), big_endian);
  }
  for (const auto& face : kFaces) {
    file.bytes.push_back(3);
    for (const std::uint32_t index : face) append(file.bytes, index, big_endian);
  }
  return file;
}

std::string ascii_ply() {
  std::string text = ply_header("ascii");
  for (const auto& corner : kCorners) {
    for (const float x : corner) absl::StrAppend(&text, x, " ");
    text += "\n";
  }
  return text + "3 0 2 1\n3 0 3 2\n";
}

std::string obj_square() {
  return "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nvn 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1/1 3/3/1 "
         "2/2/1\nf "
         "-4/1/1 4/4/1 3/3/1\n";
}

BinaryFile raw_serialized() {
  BinaryFile file;
  append(file.bytes, 0x1003, false);  // single precision, normals, texture coordinates
  file.bytes.push_back('\0');         // the name
  for (const std::uint32_t word : {4, 0, 2, 0}) append(file.bytes, word, false);
  file.first_number = file.bytes.size();
  file.numbers = 32;
  const wire::MeshData mesh = square();
  for (const auto* values : {&mesh.positions, &mesh.normals, &mesh.uvs}) file.bytes += bytes_of(*values);
  file.bytes += bytes_of(mesh.indices);
  return file;
}

std::string compress_serialized(const std::string& raw) {
  std::string compressed(compressBound(raw.size()), '\0');
  uLongf size = compressed.size();
  compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
           raw.size());
  return std::string("\x1c\x04\x04\x00", 4) + compressed.substr(0, size);
}

BinaryFile volume_file() {
  BinaryFile file;
  file.bytes = "VOL\x03";
  for (const std::uint32_t word : {1, 2, 2, 2, 1}) append(file.bytes, word, false);
  file.first_number = file.bytes.size();
  file.numbers = 6 + 8;  // the bounds, which nothing looks at, and the samples
  for (const float x : {-1.f, -1.f, -1.f, 1.f, 1.f, 1.f, 1.f, 2.f, 3.f, 4.f, 5.f, 6.f, 7.f, 8.f})
    append(file.bytes, word_of(x), false);
  return file;
}

}  // namespace tessera::stress

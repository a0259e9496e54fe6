/*
 * C++, with OpenCL's own C++ header: cl:: objects hold the planes, exceptions
 * carry errors, and destructors release everything, in any order.
 *
 * The frame is the corner of a room with a red wall, evenly lit.  Its light
 * bounces from frame to frame.
 */
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS
#include <CL/opencl.hpp>
#include <hbil/hbil.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

constexpr int width = 320, height = 180, frames = 3;

/* ------------------------------------------------------------------------ */
/* hbil in C++                                                               */

void check(hbil_status status, const hbil_context *context) {
  if (status != HBIL_SUCCESS)
    throw std::runtime_error(hbil_context_message(context));
}

using context_ptr = std::shared_ptr<hbil_context>;
using plan_ptr = std::shared_ptr<hbil_plan>;

context_ptr make_context(const cl::Context &context, const cl::Device &device) {
  hbil_context *out = nullptr;
  check(hbil_context_create(context(), device(), &out), nullptr);
  return context_ptr(out, hbil_context_destroy);
}

plan_ptr make_plan(hbil_context *context, const hbil_config &config) {
  hbil_plan *out = nullptr;
  check(hbil_plan_create(context, &config, &out), context);
  return plan_ptr(out, hbil_plan_destroy);
}

/* The frame's commands wait for `after`.  The event is the frame's. */
cl::Event enqueue(const context_ptr &context, const plan_ptr &plan,
                  const cl::CommandQueue &queue, const hbil_frame &frame,
                  const std::vector<cl::Event> &after) {
  std::vector<cl_event> list;
  for (const cl::Event &event : after)
    list.push_back(event());
  cl_event done = nullptr;
  check(hbil_enqueue_frame(plan.get(), queue(), &frame,
                           static_cast<cl_uint>(list.size()),
                           list.empty() ? nullptr : list.data(), &done),
        context.get());
  return cl::Event(done); /* which releases it */
}

/* ------------------------------------------------------------------------ */
/* The renderer                                                              */

struct gbuffer {
  std::vector<float> depth, normal, albedo,
      direct; /* normal: x, y, z, x, ... */
};

/* A floor at y = 1, a red wall at x = -2 and a back wall at z = 5, in view
 * space: x right, y down, z forward. */
gbuffer draw(const hbil_camera &camera) {
  gbuffer g;
  const double far = std::numeric_limits<double>::infinity();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double rx = (x + 0.5 - camera.cx) / camera.fx;
      const double ry = (y + 0.5 - camera.cy) / camera.fy;
      const double floor_z = ry > 0.0 ? 1.0 / ry : far;
      const double wall_z = rx < 0.0 ? -2.0 / rx : far;
      const double z = std::min({5.0, floor_z, wall_z});
      const bool wall = z == wall_z, floor = !wall && z == floor_z;
      const float grey = wall ? 0.05f : 0.8f;
      g.depth.push_back(static_cast<float>(z));
      g.normal.insert(g.normal.end(), {wall ? 1.0f : 0.0f, floor ? -1.0f : 0.0f,
                                       wall || floor ? 0.0f : -1.0f});
      g.albedo.insert(g.albedo.end(), {0.8f, grey, grey});
      g.direct.insert(g.direct.end(), {1.0f, 1.0f, 1.0f});
    }
  return g;
}

/* A buffer for these values, which are on their way when it returns. */
cl::Buffer upload(const cl::Context &context, const cl::CommandQueue &queue,
                  const std::vector<float> &values,
                  std::vector<cl::Event> &uploads) {
  const size_t bytes = values.size() * sizeof(float);
  cl::Buffer buffer(context, CL_MEM_READ_ONLY, bytes);
  uploads.emplace_back();
  queue.enqueueWriteBuffer(buffer, CL_FALSE, 0, bytes, values.data(), nullptr,
                           &uploads.back());
  return buffer;
}

cl::Device first_device() {
  std::vector<cl::Platform> platforms;
  cl::Platform::get(&platforms);
  for (const cl::Platform &platform : platforms) {
    std::vector<cl::Device> devices;
    platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    if (!devices.empty())
      return devices.front();
  }
  throw std::runtime_error("no OpenCL device");
}

/* Red and green of the light that the floor gets beside the wall. */
std::pair<float, float> floor_light(const std::vector<float> &irradiance) {
  float red = 0.0f, green = 0.0f;
  int count = 0;
  for (int y = height * 7 / 8; y < height; ++y)
    for (int x = width / 8; x < width / 4; ++x, ++count) {
      const size_t pixel = static_cast<size_t>(y * width + x);
      red += irradiance[3 * pixel];
      green += irradiance[3 * pixel + 1];
    }
  return {red / static_cast<float>(count), green / static_cast<float>(count)};
}

void run() {
  const cl::Device device = first_device();
  const cl::Context context(device);
  const cl::CommandQueue queue(context, device);

  hbil_config config;
  hbil_config_init(&config);
  config.width = width;
  config.height = height;
  config.inputs.depth = {HBIL_FLOAT32, 4};
  config.inputs.normal = config.inputs.albedo = {HBIL_FLOAT32, 12};
  config.inputs.direct = config.outputs.near_irradiance = {HBIL_FLOAT32, 12};
  const context_ptr hbil = make_context(context, device);
  const plan_ptr plan = make_plan(hbil.get(), config);

  hbil_frame frame;
  hbil_frame_init(&frame);
  hbil_camera &c = frame.camera;
  c.fx = c.fy = 200.0;
  c.cx = width / 2.0;
  c.cy = height / 2.0;
  for (int i = 0; i < 4; ++i)
    c.world_from_view[5 * i] = 1.0;
  const gbuffer g = draw(frame.camera);
  std::vector<cl::Event> uploads;
  const cl::Buffer depth = upload(context, queue, g.depth, uploads);
  const cl::Buffer normal = upload(context, queue, g.normal, uploads);
  const cl::Buffer albedo = upload(context, queue, g.albedo, uploads);
  const cl::Buffer direct = upload(context, queue, g.direct, uploads);
  std::vector<float> light(3 * static_cast<size_t>(width * height));
  const cl::Buffer result(context, CL_MEM_WRITE_ONLY,
                          light.size() * sizeof(float));
  frame.depth.buffer = depth();
  frame.normal.buffer = normal();
  frame.albedo.buffer = albedo();
  frame.direct.buffer = direct();
  frame.near_irradiance.buffer = result();

  std::vector<std::pair<float, float>> seen;
  for (int i = 0; i < frames; ++i) {
    const std::vector<cl::Event> lit = {
        enqueue(hbil, plan, queue, frame, uploads)};
    queue.enqueueReadBuffer(result, CL_TRUE, 0, light.size() * sizeof(float),
                            light.data(), &lit);
    seen.push_back(floor_light(light));
    std::cout << "frame " << i << ": floor by the red wall: near light "
              << seen.back().first << " red, " << seen.back().second
              << " green\n";
  }
  if (!(seen[0].first > 1.2f * seen[0].second))
    throw std::runtime_error("the red wall does not colour the floor");
  if (!(seen.back().first > seen.front().first))
    throw std::runtime_error("light does not bounce from frame to frame");
}

int main() {
  try {
    run();
    return 0;
  } catch (const cl::Error &error) {
    std::cerr << "08_cpp: " << error.what() << ": " << error.err() << "\n";
  } catch (const std::exception &error) {
    std::cerr << "08_cpp: " << error.what() << "\n";
  }
  return 1;
}

#include "amb_rotor/ros/orbit_markers.hpp"

#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr int circle_corners = 72;
constexpr double bearing_width = 0.010, disc_width = 0.004;  // m, as drawn

std_msgs::ColorRGBA colour(float red, float green, float blue, float opaque = 1.0F) {
  std_msgs::ColorRGBA c;
  c.r = red;
  c.g = green;
  c.b = blue;
  c.a = opaque;
  return c;
}

const std_msgs::ColorRGBA free_colour = colour(0.0F, 0.6F, 1.0F);
const std_msgs::ColorRGBA contact_colour = colour(1.0F, 0.3F, 0.0F);
const std_msgs::ColorRGBA clearance_colour = colour(0.1F, 0.7F, 0.2F);
const std_msgs::ColorRGBA bearing_colour = colour(0.45F, 0.48F, 0.52F, 0.55F);
const std_msgs::ColorRGBA rotor_colour = colour(0.75F, 0.75F, 0.8F, 0.5F);
const std_msgs::ColorRGBA point_colour = colour(0.9F, 0.0F, 0.8F);
const std_msgs::ColorRGBA text_colour = colour(0.95F, 0.95F, 0.95F);

geometry_msgs::Point at(double x, double y, double z) {
  geometry_msgs::Point p;
  p.x = x;
  p.y = y;
  p.z = z;
  return p;
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x,
                                          double y, double z) {
  geometry_msgs::TransformStamped t;
  t.header.frame_id = parent;
  t.child_frame_id = child;
  t.transform.translation.x = x;
  t.transform.translation.y = y;
  t.transform.translation.z = z;
  t.transform.rotation.w = 1.0;
  return t;
}

void setSize(Marker& marker, double x, double y, double z) {
  marker.scale.x = x;
  marker.scale.y = y;
  marker.scale.z = z;
}

/// A circle about (x, y); lines are drawn unlit, so it looks the same from both sides.
void circle(Marker& out, double x, double y, double z, double radius) {
  for (int i = 0; i <= circle_corners; ++i) {
    const double a = two_pi * i / circle_corners;
    out.points.push_back(at(x + radius * std::cos(a), y + radius * std::sin(a), z));
  }
}

}  // namespace

OrbitMarkers::OrbitMarkers(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      period_(numberOr(own, "period", 0.005)),
      wished_scale_(numberOr(own, "scale", 0.0)),
      force_scale_(numberOr(own, "force_scale", 5e-5)),
      clearance_shown_(numberOr(own, "clearance_shown", 0.05)),
      disc_radius_(numberOr(own, "disc_radius", 0.03)),
      trail_length_(integerOr(own, "trail_length", 5000)),
      point_count_(integerOr(own, "points", 200)) {
  model_subscriber_ = nodes_.subscribe("rotor/model", 10, &OrbitMarkers::takeInfo, this);
  state_subscriber_ = nodes_.subscribe("rotor/state", keep_all, &OrbitMarkers::takeState, this);
  contact_subscriber_ = nodes_.subscribe<ContactForces>("auxiliary_bearing/contact", keep_all,
                                                        [this](const ContactForces::ConstPtr& contact) {
                                                          if (contact->ends.size() == 2)
                                                            for (int end = 0; end < 2; ++end)
                                                              ends_[end].contact = contact->ends[end];
                                                        });
  point_subscriber_ = nodes_.subscribe<SectionPoint>("analysis/poincare", keep_all,
                                                     [this](const SectionPoint::ConstPtr& point) {
                                                       if (point->end > 1) return;
                                                       auto& points = ends_[point->end].points;
                                                       points.push_back(*point);
                                                       if (static_cast<int>(points.size()) > point_count_)
                                                         points.pop_front();
                                                     });
  // last: who waits for this topic knows that the others are heard
  publisher_ = nodes_.advertise<MarkerArray>("markers", 2, true);
}

void OrbitMarkers::takeInfo(const ModelInfo::ConstPtr& info) {
  info_ = info;
  scale_ = wished_scale_ > 0.0 ? wished_scale_ : clearance_shown_ / info->clearance;
  for (auto& end : ends_) end = End();
  next_draw_ = 0.0;
  sendFixedFrames();
}

/// world has its z upwards, as rviz likes it; the stator's y points up, its z is along the shaft.
void OrbitMarkers::sendFixedFrames() {
  std::vector<geometry_msgs::TransformStamped> all;
  all.push_back(transform("world", stator_frame, 0.0, 0.0, 0.0));
  all.back().transform.rotation.x = all.back().transform.rotation.w = std::sqrt(0.5);
  const char* letter[2] = {"a", "b"};
  for (int end = 0; end < 2; ++end) {
    all.push_back(transform(stator_frame, std::string("amb_") + letter[end], 0.0, 0.0, info_->amb_z[end]));
    all.push_back(
        transform(stator_frame, std::string("sensor_") + letter[end], 0.0, 0.0, info_->sensor_z[end]));
    all.push_back(transform(stator_frame, std::string("aux_") + letter[end], 0.0, 0.0, info_->aux_z[end]));
  }
  for (auto& t : all) t.header.stamp = info_->header.stamp;
  fixed_frames_.sendTransform(all);
}

void OrbitMarkers::sendFrames(const RotorState& state) {
  geometry_msgs::TransformStamped rotor =
      transform(stator_frame, "rotor", scale_ * state.centre_x, scale_ * state.centre_y, 0.0);
  rotor.header.stamp = state.header.stamp;
  rotor.transform.rotation.z = std::sin(0.5 * state.shaft.angle);
  rotor.transform.rotation.w = std::cos(0.5 * state.shaft.angle);
  frames_.sendTransform(rotor);
}

void OrbitMarkers::takeState(const RotorState::ConstPtr& state) {
  if (info_ == nullptr || state->run != info_->run || state->record < 0) return;
  for (int e = 0; e < 2; ++e) {
    End& end = ends_[e];
    end.x = axisOf(state->aux_position, 2 * e);
    end.y = axisOf(state->aux_position, 2 * e + 1);
    end.trail.push_back({end.x, end.y, state->contact_mode.size() == 2 && state->contact_mode[e] != 0});
    if (static_cast<int>(end.trail.size()) > trail_length_) end.trail.pop_front();
  }
  if (state->time < next_draw_ && state->time < info_->duration - 1e-9) return;
  next_draw_ = state->time + period_;
  draw(*state);
}

Marker OrbitMarkers::marker(const std::string& name, int id, int type) const {
  Marker m;
  m.header.frame_id = stator_frame;
  m.header.stamp = stamp_;
  m.ns = name;
  m.id = id;
  m.type = type;
  m.action = Marker::ADD;
  m.pose.orientation.w = 1.0;
  return m;
}

void OrbitMarkers::draw(const RotorState& state) {
  stamp_ = state.header.stamp;
  sendFrames(state);
  MarkerArray out;
  for (int end = 0; end < 2; ++end) {
    drawEnd(end, out);
    drawTrail(end, out);
  }
  Marker shaft = marker("shaft", 0, Marker::LINE_STRIP);
  setSize(shaft, 0.004, 0.0, 0.0);
  shaft.color = rotor_colour;
  for (int end = 0; end < 2; ++end)
    shaft.points.push_back(at(scale_ * ends_[end].x, scale_ * ends_[end].y, z(end)));
  out.markers.push_back(shaft);

  Marker text = marker("text", 0, Marker::TEXT_VIEW_FACING);
  text.pose.position = at(0.0, clearance_shown_ + 2.5 * disc_radius_, 0.0);
  text.scale.z = 0.014;
  text.color = text_colour;
  char words[200];
  std::snprintf(words, sizeof words, "t = %.4f s, %.1f Hz\ndisplacements x %.4g, forces %.3g mm/N",
                state.time, state.shaft.speed / two_pi, scale_, 1e3 * force_scale_);
  text.text = words;
  out.markers.push_back(text);
  publisher_.publish(out);
}

void OrbitMarkers::drawEnd(int end, MarkerArray& out) const {
  const End& now = ends_[end];
  const double cx = scale_ * now.contact.centre_x, cy = scale_ * now.contact.centre_y;
  const double clearance = scale_ * info_->clearance;
  Marker free = marker("clearance", end, Marker::LINE_STRIP);
  setSize(free, 0.001, 0.0, 0.0);
  free.color = clearance_colour;
  circle(free, cx, cy, z(end), clearance);
  out.markers.push_back(free);

  // the disc touches the bearing where its centre is on the clearance circle
  Marker bearing = marker("auxiliary_bearing", end, Marker::LINE_STRIP);
  setSize(bearing, bearing_width, 0.0, 0.0);
  bearing.color = bearing_colour;
  circle(bearing, cx, cy, z(end), clearance + disc_radius_ + 0.5 * bearing_width);
  out.markers.push_back(bearing);

  Marker disc = marker("rotor", end, Marker::LINE_STRIP);
  setSize(disc, disc_width, 0.0, 0.0);
  disc.color = rotor_colour;
  circle(disc, scale_ * now.x, scale_ * now.y, z(end), disc_radius_ - 0.5 * disc_width);
  out.markers.push_back(disc);

  Marker force = marker("contact_force", end, Marker::ARROW);
  const double fx = force_scale_ * now.contact.force_x, fy = force_scale_ * now.contact.force_y;
  if (now.contact.normal_force > 0.0 && std::hypot(fx, fy) > 1e-6) {
    const double length = std::hypot(now.x - now.contact.centre_x, now.y - now.contact.centre_y);
    const double nx = (now.x - now.contact.centre_x) / length, ny = (now.y - now.contact.centre_y) / length;
    const double px = scale_ * now.x + disc_radius_ * nx, py = scale_ * now.y + disc_radius_ * ny;
    setSize(force, 0.003, 0.007, 0.0);
    force.color = contact_colour;
    force.points = {at(px, py, z(end)), at(px + fx, py + fy, z(end))};
  } else {
    force.action = Marker::DELETE;
  }
  out.markers.push_back(force);

  if (!now.points.empty()) {
    Marker points = marker("poincare", end, Marker::SPHERE_LIST);
    setSize(points, 0.004, 0.004, 0.004);
    points.color = point_colour;
    for (const auto& p : now.points)
      points.points.push_back(at(cx + scale_ * p.x, cy + scale_ * p.y, z(end)));
    out.markers.push_back(points);
  }
}

void OrbitMarkers::drawTrail(int end, MarkerArray& out) const {
  const auto& trail = ends_[end].trail;
  if (trail.size() < 2) return;
  Marker line = marker("orbit", end, Marker::LINE_STRIP);
  setSize(line, 0.0015, 0.0, 0.0);
  line.color = free_colour;
  for (const auto& p : trail) {
    line.points.push_back(at(scale_ * p.x, scale_ * p.y, z(end)));
    line.colors.push_back(p.contact ? contact_colour : free_colour);
  }
  out.markers.push_back(line);
}

}  // namespace amb_rotor

//! Recordings: what is written comes back, and damage costs only what is damaged.

#![allow(clippy::unwrap_used)]

mod containers;
mod damage;
mod excerpts;
mod imu;
mod joints;
mod round_trip;
mod six_joints;
mod support;
mod synchronization;

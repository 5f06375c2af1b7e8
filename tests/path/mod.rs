//! Tool paths: their time, their programs, and what they leave.

mod times;

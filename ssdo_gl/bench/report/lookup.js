"use strict";
// A front is sorted by time, and its errors fall: as in advice.py.
function mostAccurateWithin(front, ms) { return [...front].reverse().find(c => c.ms <= ms) || null; }
function cheapestWithin(front, error) { return front.find(c => c.error <= error) || null; }

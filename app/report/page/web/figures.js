// How each kind of figure is drawn: data and a width in, height and chart options out.
import { circles, mechanism, nextPoints, plan } from './drawings.js';
import { contest, network, sensitivity } from './fits.js';
import { maps, surfaces } from './maps.js';
import { along, byPoint, deviations, drift, histogram, simulated } from './points.js';
import { effect, residuals, temperature, waterfall } from './story.js';

export const kinds = {
  maps, along, surfaces, mechanism, plan, 'next-points': nextPoints, circles, 'by-point': byPoint, histogram, simulated,
  sensitivity, network, contest, waterfall, residuals, effect, temperature, deviations, drift,
};

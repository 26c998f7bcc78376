BEGIN TRANSACTION;
CREATE TABLE active_versions (
	rocket TEXT NOT NULL, 
	number INTEGER NOT NULL, checksum BIGINT, 
	PRIMARY KEY (rocket), 
	FOREIGN KEY(rocket, number) REFERENCES versions (rocket, number)
);
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('m004_checksums');
CREATE TABLE configurations (
	rocket TEXT NOT NULL, 
	config TEXT NOT NULL, 
	dry_mass DOUBLE, 
	diameter DOUBLE, 
	length DOUBLE, 
	cd DOUBLE, 
	source TEXT NOT NULL, checksum BIGINT, 
	PRIMARY KEY (rocket, config)
);
CREATE TABLE drafts (
	name TEXT NOT NULL, 
	content JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (name)
);
CREATE TABLE flights (
	entry INTEGER NOT NULL, 
	rocket TEXT NOT NULL, 
	flight_id TEXT NOT NULL, 
	config TEXT NOT NULL, 
	motor TEXT NOT NULL, 
	date_time TEXT, 
	site TEXT NOT NULL, 
	notes TEXT NOT NULL, 
	log TEXT NOT NULL, 
	log_digest TEXT, 
	source TEXT NOT NULL, 
	dry_mass DOUBLE, 
	diameter DOUBLE, 
	delay DOUBLE, 
	site_elevation DOUBLE, 
	temperature DOUBLE, 
	pressure DOUBLE, 
	humidity DOUBLE, 
	wind DOUBLE, 
	rail_length DOUBLE, 
	rail_angle DOUBLE, 
	apogee DOUBLE, 
	top_speed DOUBLE, 
	burn_time DOUBLE, 
	peak_accel DOUBLE, 
	avg_accel DOUBLE, 
	coast_to_apogee DOUBLE, 
	apogee_to_eject DOUBLE, 
	eject_altitude DOUBLE, 
	descent_speed DOUBLE, 
	duration DOUBLE, 
	extra JSON NOT NULL, 
	entered JSON, checksum BIGINT, 
	PRIMARY KEY (entry), 
	UNIQUE (rocket, flight_id), 
	FOREIGN KEY(log_digest) REFERENCES logs (digest)
);
INSERT INTO "flights" VALUES(1,'Lark','flight-dd2afbb08f','','F24-4W',NULL,'','edited','','dd2afbb08f4ae03add6b69d894f0cdf5e58c0446afd30fb9a71ab61f324f5069','sample_logs/perfectflite__drogue_and_main.pf2',NULL,NULL,NULL,239.8776,NULL,NULL,NULL,NULL,NULL,NULL,100.0,64.657,1.157,71.819,55.878,4.55,0.05,162.76,8.91,NULL,'{"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}','{"flight_id": "flight-dd2afbb08f", "rocket": "Lark", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "tags": [], "notes": "made up", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": 239.8776, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 162.765, "top_speed": 64.657, "burn_time": 1.157, "peak_accel": 71.819, "avg_accel": 55.878, "coast_to_apogee": 4.55, "apogee_to_eject": 0.05, "eject_altitude": 162.76, "descent_speed": 8.91, "duration": null, "extra": {"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "apogee_sd_m": "1", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}}',1421630263);
INSERT INTO "flights" VALUES(2,'Table','7','','F24-4W',NULL,'','','','75872ab87acce250f09b0060bab174d096b91a3bd5e4ee683e9666e1cd267b85','/tmp/old/t.csv',NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,250.0,NULL,NULL,NULL,NULL,5.0,NULL,NULL,NULL,NULL,'{"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Bob"}','{"flight_id": "7", "rocket": "Table", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "tags": [], "notes": "", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 250.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": 5.0, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Ann"}}',3870555728);
INSERT INTO "flights" VALUES(3,'Table','8','','F24-4W',NULL,'','','','75872ab87acce250f09b0060bab174d096b91a3bd5e4ee683e9666e1cd267b85','/tmp/old/t.csv',NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,5.0,NULL,NULL,NULL,NULL,'{"apogee_sd_m": "3"}',NULL,2393166961);
CREATE TABLE journal (
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	command TEXT NOT NULL, 
	what TEXT NOT NULL, 
	target INTEGER, 
	images JSON, checksum BIGINT, images_checksum BIGINT, 
	PRIMARY KEY (number), 
	FOREIGN KEY(target) REFERENCES journal (number)
);
INSERT INTO "journal" VALUES(1,'2026-11-22T18:05:52+00:00','import','flight-dd2afbb08f from perfectflite__drogue_and_main.pf2',NULL,'[["flights", null, {"flight_id": "flight-dd2afbb08f", "rocket": "Lark", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "notes": "made up", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": 239.8776, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 162.765, "top_speed": 64.657, "burn_time": 1.157, "peak_accel": 71.819, "avg_accel": 55.878, "coast_to_apogee": 4.55, "apogee_to_eject": 0.05, "eject_altitude": 162.76, "descent_speed": 8.91, "duration": null, "extra": {"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "apogee_sd_m": "1", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}, "entry": 1, "log_digest": "dd2afbb08f4ae03add6b69d894f0cdf5e58c0446afd30fb9a71ab61f324f5069", "source": "sample_logs/perfectflite__drogue_and_main.pf2"}]]',1336334888,299869467);
INSERT INTO "journal" VALUES(2,'2026-11-22T18:05:52+00:00','import','7, 8 from t.csv',NULL,'[["flights", null, {"flight_id": "7", "rocket": "Table", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "notes": "", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 250.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": 5.0, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Ann"}, "entry": 2, "log_digest": "75872ab87acce250f09b0060bab174d096b91a3bd5e4ee683e9666e1cd267b85", "source": "/tmp/old/t.csv"}], ["flights", null, {"flight_id": "8", "rocket": "Table", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "notes": "", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": null, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": 5.0, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {"apogee_sd_m": "3"}, "entry": 3, "log_digest": "75872ab87acce250f09b0060bab174d096b91a3bd5e4ee683e9666e1cd267b85", "source": "/tmp/old/t.csv"}]]',3321271149,1504697719);
INSERT INTO "journal" VALUES(3,'2026-11-22T18:05:52+00:00','edit','flight-dd2afbb08f (apogee)',NULL,'[["flights", {"entry": 1, "apogee": 162.765, "extra": {"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "apogee_sd_m": "1", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}, "entered": null}, {"entry": 1, "apogee": 100.0, "extra": {"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}, "entered": {"flight_id": "flight-dd2afbb08f", "rocket": "Lark", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "tags": [], "notes": "made up", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": 239.8776, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 162.765, "top_speed": 64.657, "burn_time": 1.157, "peak_accel": 71.819, "avg_accel": 55.878, "coast_to_apogee": 4.55, "apogee_to_eject": 0.05, "eject_altitude": 162.76, "descent_speed": 8.91, "duration": null, "extra": {"Software": "1.1", "Flight Number": "12", "Main Setting": "200", "Apogee Delay": "0", "Drogue At": "5.60", "Main At": "11.95", "Max Drogue Current": "4.1", "stated_apogee_m": "161.544", "apogee_sd_m": "1", "top_speed_sd_mps": "4.2", "burn_time_sd_s": "0.13", "peak_accel_sd_g": "1.9", "avg_accel_sd_g": "0.73", "coast_to_apogee_sd_s": "0.094", "apogee_to_eject_sd_s": "0.12", "eject_altitude_sd_m": "1", "descent_speed_sd_mps": "0.27", "time_to_apogee_s": "5.707", "time_to_apogee_sd_s": "0.12", "device": "PerfectFlite SL100", "firmware": "1.3", "serial": "3107", "log_format": "perfectflite"}}}]]',859162383,1565216431);
INSERT INTO "journal" VALUES(4,'2026-11-22T18:05:52+00:00','edit','flight-dd2afbb08f (notes)',NULL,'[["flights", {"entry": 1, "notes": "made up"}, {"entry": 1, "notes": "edited"}]]',3491711786,296625973);
INSERT INTO "journal" VALUES(5,'2026-11-22T18:05:52+00:00','edit','7 (extra)',NULL,'[["flights", {"entry": 2, "extra": {"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Ann"}, "entered": null}, {"entry": 2, "extra": {"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Bob"}, "entered": {"flight_id": "7", "rocket": "Table", "config": "", "motor": "F24-4W", "date_time": null, "site": "", "tags": [], "notes": "", "log": "", "dry_mass": null, "diameter": null, "delay": null, "site_elevation": null, "temperature": null, "pressure": null, "humidity": null, "wind": null, "rail_length": null, "rail_angle": null, "apogee": 250.0, "top_speed": null, "burn_time": null, "peak_accel": null, "avg_accel": null, "coast_to_apogee": 5.0, "apogee_to_eject": null, "eject_altitude": null, "descent_speed": null, "duration": null, "extra": {"apogee_sd_m": "about 2", "coast_to_apogee_sd_s": "0.25", "Crew": "Ann"}}}]]',1880619032,2671240997);
INSERT INTO "journal" VALUES(6,'2026-11-22T18:05:52+00:00','tag','7 mine',NULL,'[["tags", null, {"entry": 2, "position": 0, "tag": "mine"}]]',1800541440,1456358588);
CREATE TABLE logs (
	digest TEXT NOT NULL, 
	size INTEGER NOT NULL, 
	content BLOB NOT NULL, 
	PRIMARY KEY (digest)
);
INSERT INTO "logs" VALUES('dd2afbb08f4ae03add6b69d894f0cdf5e58c0446afd30fb9a71ab61f324f5069',14397,X'789C759BCD6E64370E85F70DF81D6A9704E86A5CEAF7CABB4632C926190CD041F69EA4D263C06E373CF6CCE4EDE7F21C954B25F20259B48B164D519F28EAA8F28FD3F39FA7DF5F7E7CB87F391D3EFD2CCB72F3EEC7FBE7C7FFDE3D9F6E0FF221DEBCFBF4F4E7CBF947D97E3C3DDFDF3D1CFEFEFAF8CFD3F3ED21CA526FDE7DFCFAF4F9B4FD468ECB37878F3FFD7CF3EEA7E7A7D72F7F1CFEF670FACFDDCBFDD397DB435DEB37875F3E6DB66DECA7BBC7AFFFBE3DA4751BBCFDF1CFFF7A79F328E1E6DD2F77F75F0E9F4E2F2FF75F3EDF1E8246C53F71F8E1F470F7D7ED61FBE087E7A7CFAFA7C3C797EDCF7E284B1FA43F8A7C68597FFEDFA1FFD2F7AFCFCFA72F9B29E914BE7F7A7CDC7EDAFEFEE3DD1FA7C3EBD79B779BBBBB97BBDBC3B7BFDE3F9EDE1F3E3EBCDCBFBCFEB1FDEBB7D3C3D3EFF72F7FBD3FFC7A7AFC7A7ABE7B797D3E1DBEFDF1BBCDF4F4F072F7F9F4DDCDBBE5C3B2BC3FC8FB4308EF0F75CBDAF6D3FAA14558F2FB43DCFE135A0496A416D97E6B33A63E260C96EDE3B21997D11B2C41FFCEE6A314E32E6C83246D1F17E34F3D48DD7E4EC661CC8CBA5D3944E469FBB5B08D129DC2E431E9ACA2C6625D6AD8B16DB66083CC3AE1ED6389C9F82C9A0FD14944E3B36CE3B2FACCC1F8ACDBEF158DB3C4D127E650331322558CCF55FFAD495BEDDAE8E72DA96D357136CDE6A2936FD5386DB927252C69F22AA424A851E6940A40112CC7D2268A04AC88262E9C176370ABCE24C328C62D882988364FD10A99A930DA68418D22236D4654C08D341DB9CEAB25240719AA6DC24A804E90A0C69954013B218CC6C16D06ABEBB09A43B44A4F88C0A019B78A4F483AB258B7CA4F50DF5266B8040005A42FAF135D0282820E976C73AB0805B097A371AB0C05C097AA8956172A20B769761BC050686DD8263218755B2E6530868B51198A8AA6C4320116C050042BD1BAD5CF234A419C010B6028C634188768F5DF312D5E31086028A21A849984008662468969C62DCA0FEA419009B0C0FA53B00FE7CD1BC0505442448271AB0C452C99CC24043014B55488D82428047145B19C6B420043B1E9C8C5266145B55C0763B84C4509498B6E87C5E656194A3AA8ADC6AB229474126D2E341104253D0E4C41880028E13C987758043F49577B9D3758043E296C9FAF75422B829EA46BBDCEB38F8027C52DFE752E31113E12389E01884027E986AED667C2B8761937F854701236AB9DBB729314AA3A9F85B19F5B88D1F8546A92D25156E3B3605CBBD88638959954C3E5301F7C6A7849E32833A511C4A4BAF92B768D008CFE82390B2379D17A9E6D3EC18BAE5DAE93CF445E94873C9FD989BC68A9CA739C89BCE8B962EA5F222F7A7CA6798D1278C9CA7B9A594AE025EBC992E6754FF8BDACA7AEA97D09BC64DD9AA6B748E02523581BA7F292751FC5B99424F092B59EA6B94F4BE025A3A6E689A5D4FB9CAAB5CFF8449FA365CBD4D2045EB2D6BBB8983895971C7034189F2BC645367393CF15E3B42399DB8A045E689B594AE025ABBF30C799C10B6C32339FC14BD618658E33B31F866DDE4719BC647524339F99BCA823D35465F202DB7CE465F202DB5CEC3379519B0D13B8A0FDB153072E7A80CED9CCA4454DF366CF84456198F750262B83492EE103158DE338E39E898A0E3BCE652E13150DE42873FDC864453D1D65EE4B3261B9320E6E418B7E700C369DC085C6F9902B9D97A613993752E9C0609673B4A513A353315BA91019C5F7CD38B80DCB9B712E2485D008029A97BF901A9DFF31C9845421368ADA31CD4928BDCE68B4C946CB422383718816ECE8ADE0CD38B8CDE7D2763475AF901FAD894753F80A095A10509DF02A444897E698E66D55783CB53A8C1CDCE27CD2153F9A825A7840E97DE2681ADFC213AA2109739B5EFA11B5AAB14D6E2BCFA8350FC637C02A0F291AE7682B4FA9557CB738A62A123FD7FFCABEA66A12F25C092A1B9B9A4C6E618CE793FF78BEE20F6ED1DAD4C5240153416F53AA1F2D9A9B12BDDC567637303AD1A2BDC9E33C07B7E86FF47AE9458B0627A7C138B845879383891653014359CC926124184A65300E6EC150CA7EB4602889BF6460282D9EDB950CE939FF9621198CB937B15312A21AD93C04DF2D1842ED33DAC54A86C2EA45BB92A150BCDCAE64288C891FDC82A1E026612543AC60EB04D84A86247B80AD6448468606B76048C44F02185ADCCDBB92A1A5F86EC1D0124CB43462A418123095B79BD55BE207B72BEE64D98FB66164F2496818E956B00686E2DABC681B6FE76BF1DC36DECE579BDB08633E1B4DB48DB77314294342E3EDBC663F5ADCCE6BF4A3C5ED5CAF3B9E5BDCCE4BF5006BBC9D9732247EB94C85B7F3E891D0FAED3CF86E713B2FEEE66DBC9D67773B34DECE6174DCE2769E6DBD85110CE5C5448BA980A1543D6E1B194AEEA1D3C8108A94A909423139FA254CBAA0CC32355705A1A81C63343BA25B31D61E3C1156CA3CCD0B59A82F4304B20B279498235A31B3D9842AF3B575F40C98C40558BAD42CD52358BAD82C761F7346E049EC01C4B1006A69261BDD0A2DCD96495A81D4E2D649A1EC1C17F76C130ACF90F0EC512C949EC3556F25C38C201C36773FCBD295C3E07A962E1D8EA4CB68D5B1AB7B1409056808960E7554A0C31A5C9E29418775319E23ADD049FD3CF38750DD7DAD568CF5A9EB3274718BB1741D1A25CCF30C21BAB84D8F74259A452CCFD47529BAECE5195A34DA292FCF14A3DD335FBA1A9DFDDDDDE5E804AEE69B80743D1A56533EA50BD2299B6C7046E02A8D5C5D3C7749FAAA9A2DA355C7C6D58D99A27488C5DD2954A583DF580965E96E753C83ABB09A158CB0822BDC2BED4E09FD552CB93C539A0E415C36427FDFF0A9A3381D649CEFE8195C897B5009E5E9800EEB3A66CE085C2DABCB3305EAB0D49D98C1D5E25E0E84127558C4E5991AB534F78E2414A9F14EE6F04C991A4F4F4EADA3502DBC0E1A9E29550BAB99A18E62B5A0D78AF3FD4B28570BAA5934559482351EBEAC722094AC05B5CEBC9448EC8F661AF3F553096704D90895D0E87B42E11A2F666F42C8E859B9C2ABD831983C53BC16F47946E513CAD7DD6A569002369ED48E671570F48C97145460F3BA2D14B105B75523FB08656CBCC71D83B3829A886E7556105CA13E0727CFE0AA60468667CAD978EA3B1A7D522868F7B169A68E92361E4C1DCF14B5F14EF8661D3D83AB326652062BB8CAE37C47CFE08A56276670A54F904E36286FE30578F2CC1981AB9CDD3C53E21634C7C15047911B0F986E36C015AC32F7CE42A11B0FF6C7EB57BA6EC558CD9579A6138ADD82C6FB3ACF9C11B8C259E6C50CAED0977B797E7B757DCBE41873BB8C75620657AAC11D8D7E2D14BEF1F06AF551A1F4DDADE6513CF7077ED9F10CAEA05B58362880D36AD471A1042E387F6D9E29824BF4A9A30C2EB1BA79A6128EB7E4B7B1619811B882D5E8F942391C5F0299B2D1ADF96CB5D45114C763F3D13C0D0B757181DEE279065771D9F10CAE82AD489C11B80A2357A36770157CEA288F0BFA0D2F667005A5474C7D2E97AF8D389EA9904B08AE674AE4782477A8A3464EEBF50A722CB80ACB8E677025ABBB5328930B6E6D963AEAE4B45AEA28940B7A244B1D95725AAF770A6704AE643C1746CFE00A02965D418AE578F977D8A05A2EB2970D7085DECC8B195CE1A669773705735AAFB3C119812BF47596E7D2BF8CE457246AE6F8FA96930D8AE6F822935337A89AD3B3CD0665737C29C15941EAE6DD3A3F5C098573C1D3826583CA39AD5ECCFA431B8BD918B262855ED3E682D2792B6E71A674DECA8E5B65AAD94470328A54F3771FA5F31677DC96F348BBAB299DB7F1701CDD2A4E10193DB7F85A5BDB49AEC2B456935B4E45595AAB0B1AA57374CCB652503A5F7DCC289DA39BB67582D2F9EA6F394AE757C6D1AD7EB6FA858DD2F9EAF71694CEABDF76523AAFD5CD2DA5F33AB60EA35B4801C5ED2B289D57BFA4513AAF36099C8A32547DC0289D57BF9E513AAFFE5147E9BCB41DB7F806890F18A5F3D276DC2A43A518B79C8A3274D5955FDC523ADF69E8299D171F304AE7C53656DD98BBD1724BE9BCF86D15A5F362FB8808239E81DB504D46B77806F6734BE93CFBBB8CD279DE4B029E81FD868AD279CE3B6EF93502132DA78267601F304AE75976968CCFC03BB9E533F04E6EF93D25975B4AE7699CE7E8164F78D52441BF2E47E53C25CF6DA070CEDE7D5EB2B07C387FFFC7262150364F6E050B54CDD388C9E8164F78E2711BA8995F35F5324C0592B97B730E5D315F77DCF2CB911E09A1EBE5D80EF377104297CBDD1E3574B53CECB88558EE56B070D6CA77A28554EEF64D814A795C3CC04217CAF792C02FD87A152C7499DCEDD44357C96D12228D7932CA30925AA61B6D97C8A31B6D57C883CB6D17C8FD24D04DF0732B5D6EF22A58A03A7ED5BE8F6E2936E9C86CDD526B72B703A57171FBD1205D11D8899617379704EAE268CDAF6B02A7C2F67AC72DBB6B97048AE26EAF142889BB57944041DC6D1703E570B7510A14C3D370CDBBB015CEFF3F88337D0AE169C7279EEDBCB6235004B76D386DFA8BC88B75A9E00CA6D123B0518F33515DF9F61DE63ECAAC0F35EF65FA821B2DA507680A20C5EE9D006BFFFC68E0A4CEBD5C820F43F0EB72651A3DAED7F31A1D368E7266DCF2CE8CE3F97F16B2FE286A7BFEBAA00DE335375DCCBEFCA5D15DD8098F2AB69BC078E6C2892EEE4697965D77E93AE732449E9771E9477FEC64A6E9D2D4A998F5D540A57A5CF9D161BD9AD4E8AFE6DDD5E84C98238DE2B4EFAE5D676274D7CEF1CDBD5DA026BD38F34D6724CCEAA6331266B6D4A12F89BDC0420D3A388B9BCE4438B1C56B5EDF82FB3FCC97F14E');
INSERT INTO "logs" VALUES('75872ab87acce250f09b0060bab174d096b91a3bd5e4ee683e9666e1cd267b85',148,X'789C4BCBC94CCF2889CF4CD129CA4FCE4E2DD1C9CD2FC92FD2492CC84F4F4D8DCF85318A5380ECE4FCC4E292F892FC789820A6480A50D0B928B59CCB5C272431292755C7CDC844D7245CC7C8D440273129BFB444C148C754C740CFC854C7312F8FCB0255958E315052870B00DAFC311B');
CREATE TABLE predictions (
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	rocket TEXT NOT NULL, 
	flight_id TEXT NOT NULL, 
	digest TEXT NOT NULL, 
	payload JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (number)
);
CREATE TABLE tags (
	entry INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	tag TEXT NOT NULL, 
	PRIMARY KEY (entry, position), 
	FOREIGN KEY(entry) REFERENCES flights (entry)
);
INSERT INTO "tags" VALUES(2,0,'mine');
CREATE TABLE versions (
	rocket TEXT NOT NULL, 
	number INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	payload JSON NOT NULL, checksum BIGINT, 
	PRIMARY KEY (rocket, number)
);
CREATE INDEX flights_by_id ON flights (flight_id);
CREATE INDEX flights_edited ON flights (entry) WHERE entered IS NOT NULL;
CREATE INDEX tags_by_tag ON tags (tag);
CREATE INDEX predictions_by_flight ON predictions (rocket, flight_id);
COMMIT;
